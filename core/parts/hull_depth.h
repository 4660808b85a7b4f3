// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/parts/surface_graph.h"

namespace geond {

// The greatest depth of the surface under its convex hull, m: 0 for a convex body. The hull is taken as the meeting of
// half-spaces: over a fixed set of directions, over those the surface faces most near each of them, and, where the
// depth still counts, over the surface's own pooled normal.
double GreatestHullDepth(const SurfaceGraph& surface, double normal_radius);

}  // namespace geond
