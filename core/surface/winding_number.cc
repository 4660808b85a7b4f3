// SPDX-License-Identifier: Apache-2.0
#include "core/surface/winding_number.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

namespace geond {
namespace {

constexpr double kInverse4Pi = 1.0 / (4.0 * std::numbers::pi);
// A node is far if it lies further away than this many of its radii.
constexpr double kFar = 2.3;
// A triangle of a leaf counts as one dipole beyond this many of its radii.
constexpr double kFarTriangle = 4.0;

// Solid angle of a triangle seen from the origin (Van Oosterom and Strackee 1983).
double SolidAngle(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  const double la = a.norm(), lb = b.norm(), lc = c.norm();
  const double denominator = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
  return 2.0 * std::atan2(a.dot(b.cross(c)), denominator);
}

}  // namespace

WindingNumber::WindingNumber(const TriangleMesh& mesh) {
  for (int t = 0; t < static_cast<int>(mesh.triangles.size()); ++t) {
    const auto& [a, b, c] = mesh.triangles[t];
    corners_.push_back({mesh.vertices[a], mesh.vertices[b], mesh.vertices[c]});
    centers_.push_back(TriangleCentroid(mesh, t));
    area_vectors_.push_back(TriangleAreaVector(mesh, t));
    double radius = 0.0;
    for (const Eigen::Vector3d& corner : corners_[t]) radius = std::max(radius, (corner - centers_[t]).squaredNorm());
    radii_squared_.push_back(radius);
  }
  order_.resize(centers_.size());
  std::iota(order_.begin(), order_.end(), 0);
  if (!order_.empty()) Build(0, static_cast<int>(order_.size()));
}

WindingNumber::WindingNumber(const std::vector<Eigen::Vector3d>& points, const std::vector<Eigen::Vector3d>& area_vectors)
    : centers_(points), area_vectors_(area_vectors) {
  order_.resize(centers_.size());
  std::iota(order_.begin(), order_.end(), 0);
  if (!order_.empty()) Build(0, static_cast<int>(order_.size()));
}

int WindingNumber::Build(int begin, int end) {
  const int index = static_cast<int>(nodes_.size());
  Node node;
  node.begin = begin;
  node.end = end;
  Eigen::AlignedBox3d box;
  node.center.setZero();
  node.area_vector.setZero();
  node.moment.setZero();
  double total = 0.0;
  for (int i = begin; i < end; ++i) {
    const int e = order_[i];
    const double area = area_vectors_[e].norm();
    box.extend(centers_[e]);
    node.center += area * centers_[e];
    node.area_vector += area_vectors_[e];
    total += area;
  }
  node.center = total > 0.0 ? Eigen::Vector3d(node.center / total) : box.center();
  for (int i = begin; i < end; ++i) {
    const int e = order_[i];
    node.moment += (centers_[e] - node.center) * area_vectors_[e].transpose();
    double reach = (centers_[e] - node.center).norm();
    if (!corners_.empty()) {
      for (const Eigen::Vector3d& corner : corners_[e]) reach = std::max(reach, (corner - node.center).norm());
    }
    node.radius = std::max(node.radius, reach);
  }
  nodes_.push_back(node);
  if (end - begin <= 8) return index;
  int axis;
  box.sizes().maxCoeff(&axis);
  const int middle = begin + (end - begin) / 2;
  std::nth_element(order_.begin() + begin, order_.begin() + middle, order_.begin() + end, [&](int i, int j) {
    return centers_[i][axis] != centers_[j][axis] ? centers_[i][axis] < centers_[j][axis] : i < j;
  });
  Build(begin, middle);
  nodes_[index].right = Build(middle, end);
  return index;
}

double WindingNumber::At(const Eigen::Vector3d& p) const {
  if (nodes_.empty()) return 0.0;
  double sum = 0.0;
  std::array<int, 64> stack;
  int depth = 0;
  stack[depth++] = 0;
  while (depth > 0) {
    const int index = stack[--depth];
    const Node& node = nodes_[index];
    const Eigen::Vector3d r = node.center - p;
    const double squared = r.squaredNorm();
    if (squared > kFar * kFar * node.radius * node.radius && squared > 0.0) {
      const double distance = std::sqrt(squared), cubed = squared * distance;
      // Dipole and the term of the first order of r / r^3 about the center.
      sum += kInverse4Pi * (r.dot(node.area_vector) / cubed + node.moment.trace() / cubed -
                            3.0 * r.dot(node.moment * r) / (cubed * squared));
      continue;
    }
    if (node.right >= 0) {
      stack[depth++] = node.right;
      stack[depth++] = index + 1;
      continue;
    }
    for (int i = node.begin; i < node.end; ++i) {
      const int e = order_[i];
      const Eigen::Vector3d to = centers_[e] - p;
      const double to_squared = to.squaredNorm();
      if (!corners_.empty() && to_squared < kFarTriangle * kFarTriangle * radii_squared_[e]) {
        sum += kInverse4Pi * SolidAngle(corners_[e][0] - p, corners_[e][1] - p, corners_[e][2] - p);
      } else {
        // A point stands for a disc of its area: nearer than the disc's radius its pull no longer grows.
        const double s = std::max(to_squared, area_vectors_[e].norm() / std::numbers::pi);
        if (s > 0.0) sum += kInverse4Pi * to.dot(area_vectors_[e]) / (s * std::sqrt(s));
      }
    }
  }
  return sum;
}

}  // namespace geond
