// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "core/parts/surface_graph.h"

namespace geond {

// A surface in patches of about equal area: few enough to ask each for its surroundings, whatever the triangles are.
// Sums of areas, area vectors and moments over patches are those over their triangles.
struct Patches {
  SurfaceGraph graph;
  std::vector<int> of;  // a piece of the finer surface: its patch
};

// About `wanted` connected patches, each the pieces nearest to its middle (Lloyd's iteration over the surface); where
// the surface has less than twice as many pieces, each is a patch of its own.
Patches MakePatches(const SurfaceGraph& surface, int wanted);

// The mean by area of a value of pieces, a patch.
std::vector<double> MeanOfPatches(const SurfaceGraph& surface, const Patches& patches,
                                  const std::vector<double>& values);

// The label that most of a patch's area has; of equals the least.
std::vector<int> LabelsOfPatches(const SurfaceGraph& surface, const Patches& patches, const std::vector<int>& labels);

}  // namespace geond
