// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stop_token>
#include <vector>

#include "core/parts/part_surface.h"

namespace geond {

// Where a boundary between two regions counts as a cut.
struct MergeSettings {
  double radius = 0.0;         // m, over which concavity is pooled
  double threshold = 0.02;     // boundaries below are dissolved, the weakest first
  double convex_clip = -0.1;   // an edge counts for no less
  double small_area = 0.01;    // regions below this share of the area join the neighbour with the weakest boundary
};

// The mean, by length, of the concavity along the boundary of two regions.
struct RegionBoundary {
  int a = 0, b = 0;  // a < b
  double length = 0.0;
  double weighted = 0.0;  // sum of length times clipped concavity
  double strength() const { return length > 0.0 ? weighted / length : 0.0; }
};

// All boundaries between labels, in order of (a, b).
std::vector<RegionBoundary> MeasureBoundaries(const PartSurface& surface, const std::vector<int>& labels,
                                              const MergeSettings& settings);

// Dissolves weak boundaries, weakest first, measuring anew until none is weak; then small regions. Labels are numbered anew
// from 0 in the order of the surface.
void MergeRegions(const PartSurface& surface, const MergeSettings& settings, std::vector<int>& labels,
                  std::stop_token stop = {});

}  // namespace geond
