// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "core/geometry/triangle_mesh.h"

namespace geond {

// Values at the nodes of a regular grid; as a signed distance (m) negative inside.
struct SignedGrid {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  // of node (0, 0, 0)
  double step = 1.0;                                 // m between nodes
  std::array<int, 3> size{0, 0, 0};                  // nodes along x, y, z
  std::vector<float> value;                          // x fastest

  SignedGrid() = default;
  // Covers the box with at least one node beyond it on each side; node (.., .., k) lies on z = 0 for some k. Throws
  // std::invalid_argument if that takes more than max_nodes.
  SignedGrid(const Eigen::AlignedBox3d& box, double step, float fill, std::size_t max_nodes = 200'000'000);

  std::size_t count() const { return static_cast<std::size_t>(size[0]) * size[1] * size[2]; }
  std::size_t index(int i, int j, int k) const { return (static_cast<std::size_t>(k) * size[1] + j) * size[0] + i; }
  Eigen::Vector3d node(int i, int j, int k) const { return origin + step * Eigen::Vector3d(i, j, k); }

  // Trilinear value at p and its gradient; p outside the grid is moved to its border.
  double Sample(const Eigen::Vector3d& p, Eigen::Vector3d* gradient = nullptr) const;
};

// The surface value = 0, outward where the value grows: closed if the value is positive all over the border of the grid, and
// always manifold, for the six tetrahedra a cell is cut into fill space without gaps and no node counts as zero.
TriangleMesh MarchingTetrahedra(const SignedGrid& grid);

}  // namespace geond
