// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/geometry/triangle_mesh.h"

namespace geond::shapes {

// The unit sphere: an icosahedron whose edges are cut into 2^levels, 20 * 4^levels triangles.
TriangleMesh Sphere(int levels);
// The sphere stretched to half axes a, b, c.
TriangleMesh Ellipsoid(int levels, double a, double b, double c);
// The cube [0, 1]^3, each face cut into n by n squares of two triangles. grading > 1 crowds the cuts towards the edges:
// u -> u^grading on either half.
TriangleMesh Cube(int n, double grading = 1.0);
// A torus about z.
TriangleMesh Torus(double major, double minor, int around, int across);
// The outside of two unit spheres that meet at right angles (distance sqrt 2), rings along z.
TriangleMesh Peanut(int rings_a_lobe);
TriangleMesh Merged(const TriangleMesh& a, const TriangleMesh& b);

// Its exact density for unit charge at p on the surface (image charges 1, 1 and -1/sqrt 2).
double PeanutDensity(const Eigen::Vector3d& p);
constexpr double kPeanutCapacitance = 1.2928932188134525;  // 2 - 1/sqrt 2
// The exact density of an ellipsoid for unit charge.
double EllipsoidDensity(const Eigen::Vector3d& p, double a, double b, double c);
// Its capacitance, 1/R_F(a^2, b^2, c^2), by the duplication theorem (DLMF 19.36.1).
double EllipsoidCapacitance(double a, double b, double c);

// The root of the mean over the area of (density / exact - 1)^2.
double RelativeRms(const TriangleMesh& mesh, const std::vector<double>& density, const std::vector<double>& exact);

}  // namespace geond::shapes
