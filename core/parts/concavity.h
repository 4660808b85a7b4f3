// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "core/parts/surface_graph.h"

namespace geond {

// A border between two pieces of a surface, as one of its two arcs.
struct SurfaceEdge {
  int from = 0, arc = 0, to = 0;
};

// The borders whose two pieces satisfy `wanted(from, to)`, from < to.
template <typename Wanted>
std::vector<SurfaceEdge> CollectEdges(const SurfaceGraph& surface, const Wanted& wanted) {
  std::vector<SurfaceEdge> edges;
  for (int t = 0; t < surface.n(); ++t) {
    for (int arc = surface.first[t]; arc < surface.first[t + 1]; ++arc) {
      if (surface.to[arc] > t && wanted(t, surface.to[arc])) edges.push_back({t, arc, surface.to[arc]});
    }
  }
  return edges;
}

// The signed concavity of the surface between two sets of pieces a and b is ((N_b - N_a).(x_a - x_b)) / (2 |x_a -
// x_b|), N the direction of the sum of area vectors, x the mean place: 0 flat, towards 1 a deep valley, negative a
// ridge. Sums of area vectors depend on the rim of a patch alone, so that noise inside it cancels.

// The concavity across an edge, its sides being the pieces of the labels on either side within `radius` whose
// normals do not face away (a thin part's other wall is not asked).
double ConcavityBetweenLabels(const SurfaceGraph& surface, BallWalk& walk, const SurfaceEdge& edge,
                              const std::vector<int>& labels, double radius);

// The concavity across an edge, its sides being divided by the plane through the edge's middle, across the way from
// centroid to centroid.
double ConcavityAcross(const SurfaceGraph& surface, BallWalk& walk, const SurfaceEdge& edge, double radius);

}  // namespace geond
