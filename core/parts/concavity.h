// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "core/parts/part_surface.h"

namespace geond {

// An edge of the mesh between two triangles.
struct SurfaceEdge {
  int triangle = 0, side = 0;  // the edge over `side` of `triangle`
  int other = 0;               // the triangle beyond; triangle < other
  double length = 0.0;         // m
  Eigen::Vector3d middle;      // m
};

// The edges whose two triangles satisfy `wanted(a, b)`.
template <typename Wanted>
std::vector<SurfaceEdge> CollectEdges(const PartSurface& surface, const Wanted& wanted) {
  std::vector<SurfaceEdge> edges;
  for (int t = 0; t < surface.n(); ++t) {
    for (int side = 0; side < 3; ++side) {
      const int other = surface.neighbors[t][side];
      if (other <= t || !wanted(t, other)) continue;
      edges.push_back({t, side, other, surface.EdgeLength(t, side), surface.EdgeMiddle(t, side)});
    }
  }
  return edges;
}

// The signed concavity of the surface between two sets of triangles a and b is ((N_b - N_a).(x_a - x_b)) / (2 |x_a -
// x_b|), N the direction of the sum of area vectors, x the mean place: 0 flat, towards 1 a deep valley, negative a
// ridge. Sums of area vectors depend on the rim of a patch alone, so that noise inside it cancels.

// The concavity across an edge, its sides being the triangles of the labels on either side within `radius` whose
// normals do not face away (a thin part's other wall is not asked).
double ConcavityBetweenLabels(const PartSurface& surface, BallWalk& walk, const SurfaceEdge& edge,
                              const std::vector<int>& labels, double radius);

// The concavity across an edge, its sides being divided by the plane through the edge's middle, across the way from
// centroid to centroid.
double ConcavityAcross(const PartSurface& surface, BallWalk& walk, const SurfaceEdge& edge, double radius);

}  // namespace geond
