// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stop_token>
#include <vector>

#include "core/parts/surface_graph.h"

namespace geond {

struct SnapSettings {
  double radius = 0.0;        // m, over which concavity is pooled
  double band = 0.0;          // m, how far a boundary may move
  double scale = 0.06;        // an edge costs its length times exp(-concavity / scale),
  double convex_clip = -0.1;  // where concavity counts for no less than this
};

// Moves each boundary, one pair of regions after the other, to the cheapest cut within a band around it, so that it
// runs along creases and short ways. Labels stay; no region vanishes.
void SnapBoundaries(const SurfaceGraph& surface, const SnapSettings& settings, std::vector<int>& labels,
                    std::stop_token stop = {});

}  // namespace geond
