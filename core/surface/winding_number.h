// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>

#include "core/geometry/triangle_mesh.h"

namespace geond {

// How often a surface goes round a point: 1 inside a closed one turned outward, 0 outside, and in between near holes
// (Jacobson et al. 2013). Far triangles count as dipoles of a tree (Barill et al. 2018). Also of points with areas.
class WindingNumber {
 public:
  explicit WindingNumber(const TriangleMesh& mesh);
  // Points with outward normals times the area (m^2) each stands for.
  WindingNumber(const std::vector<Eigen::Vector3d>& points, const std::vector<Eigen::Vector3d>& area_vectors);

  double At(const Eigen::Vector3d& p) const;

 private:
  struct Node {
    Eigen::Vector3d center, area_vector;
    Eigen::Matrix3d moment;  // of the area vectors about the center
    double radius = 0.0;
    int begin = 0, end = 0;
    int right = -1;  // second child; the first follows its parent; -1: leaf
  };
  int Build(int begin, int end);

  std::vector<Eigen::Vector3d> centers_, area_vectors_;
  std::vector<std::array<Eigen::Vector3d, 3>> corners_;  // empty for points
  std::vector<double> radii_squared_;                    // of the triangles; empty for points
  std::vector<int> order_;
  std::vector<Node> nodes_;
};

}  // namespace geond
