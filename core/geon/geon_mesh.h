// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include <Eigen/Core>

#include "core/geon/geon.h"

namespace geond {

// A closed mesh of the regular primitive: vertices on its surface in regular space, triangles outward.
struct RegularMesh {
  std::vector<Eigen::Vector3d> vertices;
  std::vector<TriangleMesh::Triangle> triangles;
};

// With grid lines about `edge_length` (m, measured after deformation) apart, closer where the surface turns quickly.
RegularMesh MeshRegularPrimitive(const Geon& geon, double edge_length);

}  // namespace geond
