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

// Where the surface faces most, near each of the directions: the mean of the normals within some ten degrees, twice.
std::vector<Eigen::Vector3d> FacingDirections(const SurfaceGraph& surface,
                                              const std::vector<Eigen::Vector3d>& directions) {
  constexpr double kNear = 0.98;  // cosine
  std::vector<Eigen::Vector3d> normals, facing;
  for (const Eigen::Vector3d& area : surface.area_vectors) normals.push_back(area.stableNormalized());
  for (Eigen::Vector3d direction : directions) {
    for (int step = 0; step < 2; ++step) {
      Eigen::Vector3d sum = Eigen::Vector3d::Zero();
      for (int t = 0; t < surface.n(); ++t) {
        if (normals[t].dot(direction) > kNear) sum += surface.area_vectors[t];
      }
      direction = sum.stableNormalized();  // 0 where it faces nowhere
    }
    if (!direction.isZero()) facing.push_back(direction);
  }
  return facing;
}

}  // namespace

double GreatestHullDepth(const SurfaceGraph& surface, double normal_radius) {
  constexpr int kDirections = 600;
  const std::vector<Eigen::Vector3d>& x = surface.centroids;
  std::vector<double> depth(x.size(), std::numeric_limits<double>::infinity());
  std::set<int> extreme;  // candidates for hull corners
  std::vector<Eigen::Vector3d> directions = SpiralDirections(kDirections);
  const std::vector<Eigen::Vector3d> facing = FacingDirections(surface, directions);
  directions.insert(directions.end(), facing.begin(), facing.end());
  for (const Eigen::Vector3d& direction : directions) {
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
