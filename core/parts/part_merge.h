// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stop_token>
#include <vector>

#include "core/parts/surface_graph.h"

namespace geond {

// Where a boundary between two regions counts as a cut.
struct MergeSettings {
  double radius = 0.0;           // m, over which concavity is pooled
  double threshold = 0.02;       // boundaries below are dissolved, the weakest first
  double convex_clip = -0.1;     // an edge counts for no less
  double contrast_weight = 0.0;  // of the contrast of charge in the order of dissolving
  double share_weight = 0.0;     // of the share of the lesser rim in that order
  double small_area = 0.01;      // regions below this share of the area join the neighbour with the weakest boundary
};

// What is measured along the boundary of two regions, summed by length.
struct RegionBoundary {
  int a = 0, b = 0;  // a < b
  double length = 0.0;
  double concavity = 0.0;  // sum of length times clipped concavity
  double charge = 0.0;     // sum of length times charge
  double strength() const { return length > 0.0 ? concavity / length : 0.0; }
};

// All boundaries between labels, in order of (a, b). `charge` a triangle, averaged over balls.
std::vector<RegionBoundary> MeasureBoundaries(const SurfaceGraph& surface, const std::vector<int>& labels,
                                              const std::vector<double>& charge, const MergeSettings& settings);

// Dissolves the boundaries whose strength is below the threshold, measuring anew until there is none; then small
// regions. The order is that of strength + contrast_weight * contrast - share_weight * share: contrast is how far the
// charge along the boundary lies below that of the lesser region, share the boundary's part of the shorter of the two
// rims. Labels are numbered anew from 0 in the order of the surface.
void MergeRegions(const SurfaceGraph& surface, const std::vector<double>& charge, const MergeSettings& settings,
                  std::vector<int>& labels, std::stop_token stop = {});

}  // namespace geond
