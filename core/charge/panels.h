// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "core/charge/triangle_frame.h"
#include "core/geometry/triangle_mesh.h"

namespace geond::charge {

TriangleFrame MakeTriangleFrame(const Eigen::Vector3d& v1, const Eigen::Vector3d& v2, const Eigen::Vector3d& v3);

// A mesh as the solvers see it: each triangle carries a constant density, and its centroid is where the potential is
// asked for.
struct Panels {
  std::vector<double> x, y, z;   // centroids, m
  std::vector<double> area;      // m^2
  std::vector<double> diameter;  // the longest side, m
  std::size_t size() const { return area.size(); }
};

// Throws std::invalid_argument, naming the triangle, where the charge is not defined: no triangles, a vertex that is
// not finite, a triangle without area, or two with the same centroid (their equations would be the same).
Panels MakePanels(const TriangleMesh& mesh);

TriangleFrame FrameOf(const TriangleMesh& mesh, std::size_t triangle);

// The same in any precision, seen from `origin`.
template <typename Real>
TriangleFrameOf<Real> LocalFrameOf(const TriangleMesh& mesh, std::size_t triangle, const Eigen::Vector3d& origin) {
  const TriangleFrame frame = FrameOf(mesh, triangle);
  TriangleFrameOf<Real> local;
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) {
      local.vertex[i][k] = static_cast<Real>(frame.vertex[i][k] - origin[k]);
      local.edge[i][k] = static_cast<Real>(frame.edge[i][k]);
      local.outward[i][k] = static_cast<Real>(frame.outward[i][k]);
    }
    local.length[i] = static_cast<Real>(frame.length[i]);
    local.normal[i] = static_cast<Real>(frame.normal[i]);
  }
  local.twice_area = static_cast<Real>(frame.twice_area);
  return local;
}

}  // namespace geond::charge
