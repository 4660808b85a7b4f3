// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace geond {

// The point of triangle (a, b, c) nearest to p; b = c (a segment) is allowed.
Eigen::Vector3d NearestOnTriangle(const Eigen::Vector3d& p, const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                                  const Eigen::Vector3d& c);

// A tree of axis-parallel boxes over triangles, to find the nearest one. Keeps copies of its own; const calls may run on
// many threads.
class TriangleTree {
 public:
  struct Hit {
    int triangle = -1;  // -1: the tree is empty, or nothing within the limit
    Eigen::Vector3d point = Eigen::Vector3d::Zero();
    double squared_distance = 0.0;
  };

  TriangleTree() = default;
  TriangleTree(const std::vector<Eigen::Vector3d>& vertices, const std::vector<std::array<int, 3>>& triangles);

  bool empty() const { return corners_.empty(); }
  // The nearest point of any triangle, no further than `limit` (m). Of equally near ones always the same.
  Hit Nearest(const Eigen::Vector3d& p, double limit = 1e300) const;

 private:
  struct Node {
    Eigen::AlignedBox3d box;
    int begin = 0, end = 0;  // leaf: triangles in the order of the tree
    int right = -1;          // second child; the first follows its parent; -1: leaf
  };
  int Build(int begin, int end, std::vector<Eigen::Vector3d>& centers);

  std::vector<std::array<Eigen::Vector3d, 3>> corners_;  // in the order of the tree
  std::vector<int> ids_;
  std::vector<Node> nodes_;
};

}  // namespace geond
