// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <string_view>

#include <Eigen/Core>

#include "core/geometry/point_cloud.h"
#include "core/geometry/pose.h"
#include "core/geometry/triangle_mesh.h"

namespace geond {

// The seven shapes (thesis ch. 5), numbered as there.
enum class GeonType {
  kEllipsoid = 1,
  kCylinder = 2,
  kCuboid = 3,
  kTaperedCylinder = 4,
  kTaperedCuboid = 5,
  kCurvedCylinder = 6,
  kCurvedCuboid = 7,
};
inline constexpr std::array kGeonTypes = {GeonType::kEllipsoid,      GeonType::kCylinder,
                                          GeonType::kCuboid,         GeonType::kTaperedCylinder,
                                          GeonType::kTaperedCuboid,  GeonType::kCurvedCylinder,
                                          GeonType::kCurvedCuboid};

bool IsTapered(GeonType type);
bool IsCurved(GeonType type);
// The undeformed type: cylinder of a tapered or curved cylinder, cuboid likewise; else itself.
GeonType BaseType(GeonType type);
// "ellipsoid", "cylinder", "cuboid", "tapered_cylinder", "tapered_cuboid", "curved_cylinder", "curved_cuboid".
std::string_view GeonTypeName(GeonType type);
// Throws std::invalid_argument, listing the names, if there is no such type.
GeonType GeonTypeFromName(std::string_view name);

// A geon. In G (centre at the origin, z along the axis) the undeformed surface is f = 1 with half sizes `size`; it is then
// tapered, X = (Kx z/az + 1) x, Y = (Ky z/az + 1) y (5.4), or bent towards +x (5.8).
struct Geon {
  GeonType type = GeonType::kEllipsoid;
  Pose X_TG = {};                                        // G in the frame of the data
  Eigen::Vector3d size = Eigen::Vector3d::Ones();        // half sizes ax, ay, az, m
  Eigen::Vector2d taper = Eigen::Vector2d::Zero();       // Kx, Ky in [0, 1); the +z end is the larger
  double bend = 0.0;                                     // curvature kappa >= 0, 1/m
};

// The same shape in its one form (order of axes, signs, taper and bend direction, symmetric rotations), so that equal
// shapes have equal numbers.
Geon Canonical(const Geon& geon);

// Points and outward normals on the surface, about `count` of them, spread evenly; deterministic.
PointCloud SampleGeon(const Geon& geon, int count);
// A closed mesh of the surface with edges of about `edge_length` (m), for pictures, scenes and tests.
TriangleMesh GeonMesh(const Geon& geon, double edge_length);

}  // namespace geond
