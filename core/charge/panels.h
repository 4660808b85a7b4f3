// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "core/charge/triangle_frame.h"
#include "core/geometry/triangle_mesh.h"

namespace geond::charge {

TriangleFrame MakeTriangleFrame(const Eigen::Vector3d& v1, const Eigen::Vector3d& v2, const Eigen::Vector3d& v3);

// A mesh as the solvers see it: each triangle carries a constant density, and its centroid is where the potential is asked
// for.
struct Panels {
  std::vector<double> x, y, z;   // centroids, m
  std::vector<double> area;      // m^2
  std::vector<double> diameter;  // the longest side, m
  std::size_t size() const { return area.size(); }
};

// Throws std::invalid_argument, naming the triangle, where the charge is not defined: no triangles, a vertex that is not
// finite, a triangle without area, or two with the same centroid (their equations would be the same).
Panels MakePanels(const TriangleMesh& mesh);

TriangleFrame FrameOf(const TriangleMesh& mesh, std::size_t triangle);

}  // namespace geond::charge
