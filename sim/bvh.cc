// SPDX-License-Identifier: Apache-2.0
#include "sim/bvh.h"

#include <algorithm>
#include <utility>

#include <Eigen/Geometry>

namespace geond::sim {
namespace {
constexpr int kLeafSize = 4;
}

Bvh::Bvh(std::vector<Triangle> triangles) : triangles_(std::move(triangles)) {
  if (triangles_.empty()) return;
  nodes_.reserve(triangles_.size());
  Build(0, static_cast<int>(triangles_.size()));
}

int Bvh::Build(int begin, int end) {
  const int index = static_cast<int>(nodes_.size());
  nodes_.emplace_back();
  Node node;
  const double infinity = std::numeric_limits<double>::infinity();
  node.low.setConstant(infinity);
  node.high.setConstant(-infinity);
  Eigen::Vector3d center_low = node.low, center_high = node.high;
  const auto center = [](const Triangle& t) -> Eigen::Vector3d { return t.p0 + t.p1 + t.p2; };
  for (int i = begin; i < end; ++i) {
    for (const Eigen::Vector3d* p : {&triangles_[i].p0, &triangles_[i].p1, &triangles_[i].p2}) {
      node.low = node.low.cwiseMin(*p);
      node.high = node.high.cwiseMax(*p);
    }
    center_low = center_low.cwiseMin(center(triangles_[i]));
    center_high = center_high.cwiseMax(center(triangles_[i]));
  }
  // A hair wider, so that a flat box is not lost to rounding.
  const Eigen::Vector3d hair = Eigen::Vector3d::Constant(1e-9);
  node.low -= hair;
  node.high += hair;
  node.begin = begin;
  node.end = end;
  if (end - begin > kLeafSize) {
    int axis;
    (center_high - center_low).maxCoeff(&axis);
    const int middle = begin + (end - begin) / 2;
    std::nth_element(triangles_.begin() + begin, triangles_.begin() + middle, triangles_.begin() + end,
                     [&](const Triangle& a, const Triangle& b) { return center(a)[axis] < center(b)[axis]; });
    Build(begin, middle);
    node.right = Build(middle, end);
  }
  nodes_[index] = node;
  return index;
}

// Moeller and Trumbore (1997), a hair wider than the triangle so that no ray slips through between two.
bool Bvh::Meet(const Triangle& triangle, const Ray& ray, double& t, bool& front) {
  constexpr double kHair = 1e-9;
  const Eigen::Vector3d e1 = triangle.p1 - triangle.p0, e2 = triangle.p2 - triangle.p0;
  const Eigen::Vector3d h = ray.direction.cross(e2);
  const double determinant = e1.dot(h);
  if (determinant == 0.0) return false;
  const double inverse = 1.0 / determinant;
  const Eigen::Vector3d s = ray.origin - triangle.p0;
  const double u = s.dot(h) * inverse;
  if (u < -kHair || u > 1.0 + kHair) return false;
  const Eigen::Vector3d q = s.cross(e1);
  const double v = ray.direction.dot(q) * inverse;
  if (v < -kHair || u + v > 1.0 + kHair) return false;
  t = e2.dot(q) * inverse;
  front = determinant > 0.0;
  return t > 0.0;
}

}  // namespace geond::sim
