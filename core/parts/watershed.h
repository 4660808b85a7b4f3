// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "core/parts/surface_graph.h"

namespace geond {

// Labels each triangle with the hill of `height` it stands on: from the highest triangle downwards, each joins its
// highest labelled neighbour, or begins a hill. Regions are connected, numbered by the height of their top. Ties: the
// order of the surface.
std::vector<int> Watershed(const SurfaceGraph& surface, const std::vector<double>& height);

// Connected components of the triangles whose `keep` is true, numbered in the order of the surface (thesis D.3, as a
// breadth-first search); -1 for the others.
std::vector<int> LabelComponents(const SurfaceGraph& surface, const std::vector<bool>& keep);

// Gives every triangle of label -1 the label of the nearest labelled triangle in steps over edges (correction: the
// thesis leaves the triangles of boundaries in no part). Where there is none, 0.
void FillUnlabelled(const SurfaceGraph& surface, std::vector<int>& labels);

// Splits labels whose triangles do not hang together: the largest piece keeps its label, the others join the neighbour
// with which they share the longest border. Returns whether something changed.
bool JoinSplinters(const SurfaceGraph& surface, std::vector<int>& labels);

}  // namespace geond
