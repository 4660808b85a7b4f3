// SPDX-License-Identifier: Apache-2.0
// How deep a surface dips under its convex hull.
#include "core/parts/hull_depth.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <set>

namespace geond {
namespace {

// Directions spread evenly over the sphere along a spiral (golden angle).
std::vector<Eigen::Vector3d> SpiralDirections(int count) {
  std::vector<Eigen::Vector3d> directions;
  const double golden = std::numbers::pi * (3.0 - std::sqrt(5.0));
  for (int i = 0; i < count; ++i) {
    const double z = 1.0 - (2.0 * i + 1.0) / count, r = std::sqrt(1.0 - z * z);
    directions.emplace_back(r * std::cos(golden * i), r * std::sin(golden * i), z);
  }
  return directions;
}

}  // namespace

double GreatestHullDepth(const SurfaceGraph& surface, double normal_radius) {
  constexpr int kDirections = 600;
  const std::vector<Eigen::Vector3d>& x = surface.centroids;
  std::vector<double> depth(x.size(), std::numeric_limits<double>::infinity());
  std::set<int> extreme;  // candidates for hull corners
  for (const Eigen::Vector3d& direction : SpiralDirections(kDirections)) {
    int top = 0;
    for (int t = 1; t < surface.n(); ++t) {
      if (x[t].dot(direction) > x[top].dot(direction)) top = t;
    }
    extreme.insert(top);
    const double support = x[top].dot(direction);
    for (int t = 0; t < surface.n(); ++t) depth[t] = std::min(depth[t], support - x[t].dot(direction));
  }
  // The deepest first; the own normal can only lessen the depth, so stop when no other can be deeper.
  std::vector<int> order(x.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = static_cast<int>(i);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return depth[a] > depth[b]; });
  BallWalk walk(surface);
  double greatest = 0.0;
  for (int t : order) {
    if (depth[t] <= greatest) break;
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();
    for (int k : walk.Collect(t, x[t], normal_radius)) normal += surface.area_vectors[k];
    normal = normal.stableNormalized();
    double support = x[t].dot(normal);
    for (int e : extreme) support = std::max(support, x[e].dot(normal));
    greatest = std::max(greatest, std::min(depth[t], support - x[t].dot(normal)));
  }
  return greatest;
}

}  // namespace geond
