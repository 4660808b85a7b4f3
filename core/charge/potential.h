// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace geond {

// Integral over the triangle (v1, v2, v3) of dS'/|r - r'|, exact (Wilton et al. 1984; thesis (A.1) with corrections 17 to
// 20), m. Defined everywhere, also on the triangle, its edges and vertices.
double TrianglePotential(const Eigen::Vector3d& r, const Eigen::Vector3d& v1, const Eigen::Vector3d& v2,
                         const Eigen::Vector3d& v3);

}  // namespace geond
