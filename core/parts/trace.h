// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "core/parts/surface_graph.h"

namespace geond {

// The thesis' own ways to parts, as repaired; the baseline of the default method. Both work on charge averaged over
// 0.025 of the size (the plain density is negative in places beside sharp creases) and give every triangle a part,
// those of boundaries the nearest, splinters below 1 % of the area that of a neighbour.

// The traced boundaries (D.2): from each unvisited local minimum of charge below `limit` times the least, the lowest
// first, to the unvisited neighbour of least charge, until the trail meets the surroundings of its start, an earlier
// boundary or the border of the mesh; on an open mesh then the other way from the start. Repairs: the lowest neighbour
// is taken before the others are marked; the start may be met again only after three steps; a dead end goes on over
// triangles seen but not taken. Returns the triangles of boundaries.
std::vector<bool> TraceBoundaries(const SurfaceGraph& surface, const std::vector<double>& charge, double limit);

// D.2, then the components of what is left (D.3).
std::vector<int> SegmentByTracing(const SurfaceGraph& surface, const std::vector<double>& charge, double limit);

// Components of the triangles with charge of at least `threshold` times the median by area (Fig. 6.16 b).
std::vector<int> SegmentByThreshold(const SurfaceGraph& surface, const std::vector<double>& charge, double threshold);

// The value below which half of the area lies.
double MedianByArea(const SurfaceGraph& surface, const std::vector<double>& values);

}  // namespace geond
