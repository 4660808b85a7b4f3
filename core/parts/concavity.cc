// SPDX-License-Identifier: Apache-2.0
// How concave the surface is across an edge, pooled over a length.
#include "core/parts/concavity.h"

#include <algorithm>
#include <cmath>

namespace geond {
namespace {

// One side of an edge: sums over its triangles.
struct Side {
  Eigen::Vector3d area_vector = Eigen::Vector3d::Zero();
  Eigen::Vector3d moment = Eigen::Vector3d::Zero();
  double area = 0.0;

  void Add(const SurfaceGraph& surface, int t) {
    area_vector += surface.area_vectors[t];
    moment += surface.areas[t] * surface.centroids[t];
    area += surface.areas[t];
  }
};

double Between(const Side& a, const Side& b) {
  if (a.area <= 0.0 || b.area <= 0.0) return 0.0;
  const Eigen::Vector3d normal_a = a.area_vector.stableNormalized(), normal_b = b.area_vector.stableNormalized();
  const Eigen::Vector3d way = a.moment / a.area - b.moment / b.area;
  const double length = way.norm();
  return length > 0.0 ? (normal_b - normal_a).dot(way) / (2.0 * length) : 0.0;
}

}  // namespace

double ConcavityBetweenLabels(const SurfaceGraph& surface, BallWalk& walk, const SurfaceEdge& edge,
                              const std::vector<int>& labels, double radius) {
  const int label_a = labels[edge.from], label_b = labels[edge.to];
  Eigen::Vector3d facing =
      surface.area_vectors[edge.from].stableNormalized() + surface.area_vectors[edge.to].stableNormalized();
  const std::vector<int>& ball = walk.Collect(edge.from, edge.to, surface.middles[edge.arc], radius);
  for (int pass = 0; pass < 2; ++pass) {  // the facing from the near half of the ball, then the sides
    Side a, b;
    const double limit = pass == 0 ? 0.25 * radius * radius : radius * radius;
    for (int t : ball) {
      if (t != edge.from && t != edge.to) {
        if ((surface.centroids[t] - surface.middles[edge.arc]).squaredNorm() > limit) continue;
        if (surface.area_vectors[t].dot(facing) <= 0.0) continue;
      }
      if (labels[t] == label_a) a.Add(surface, t);
      if (labels[t] == label_b) b.Add(surface, t);
    }
    if (pass == 1) return Between(a, b);
    facing = a.area_vector.stableNormalized() + b.area_vector.stableNormalized();
  }
  return 0.0;
}

double ConcavityAcross(const SurfaceGraph& surface, BallWalk& walk, const SurfaceEdge& edge, double radius) {
  const Eigen::Vector3d across = surface.centroids[edge.to] - surface.centroids[edge.from];
  const Eigen::Vector3d facing =
      surface.area_vectors[edge.from].stableNormalized() + surface.area_vectors[edge.to].stableNormalized();
  Side a, b;
  for (int t : walk.Collect(edge.from, edge.to, surface.middles[edge.arc], radius)) {
    if (t == edge.from) {
      a.Add(surface, t);
    } else if (t == edge.to) {
      b.Add(surface, t);
    } else if (surface.area_vectors[t].dot(facing) > 0.0) {
      ((surface.centroids[t] - surface.middles[edge.arc]).dot(across) < 0.0 ? a : b).Add(surface, t);
    }
  }
  return Between(a, b);
}

}  // namespace geond
