// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "core/geon/geon.h"

namespace geond {

// The geometry of one geon, point by point, all in G. "Regular" space is that of the undeformed primitive (thesis 5.1 to
// 5.3); deformations (5.4), (5.8) carry it to G.

// Largest taper and bend that leave the shape in one piece: K <= kMaxTaper, bend ax <= kMaxFold, bend az <= pi.
inline constexpr double kMaxTaper = 0.98;
inline constexpr double kMaxFold = 0.95;
// Least factor by which undoing a taper divides: beyond the apex it would be zero or negative.
inline constexpr double kTaperGuard = 1e-3;

// f^(1/p) of (5.1) to (5.3), p = 2 or 20, at a regular point: 1 on the surface, below 1 inside; homogeneous of degree one.
double Gauge(const Geon& geon, const Eigen::Vector3d& regular);
// Its gradient; along the outward normal of the regular primitive, the same at every point of a ray from the origin.
Eigen::Vector3d GaugeGradient(const Geon& geon, const Eigen::Vector3d& regular);

// The deformation (5.4) or (5.8), written so that it holds for bend = 0 too.
Eigen::Vector3d Deform(const Geon& geon, const Eigen::Vector3d& regular);
// Its inverse (5.5), (5.9), by atan2 so that half bending angles above 90 degrees come back, the taper's factor guarded.
Eigen::Vector3d Undeform(const Geon& geon, const Eigen::Vector3d& point_G);
// Outward unit normal of the deformed surface where the ray of `regular` meets the regular surface: (det J) J^-T of (5.16),
// (5.17) at that surface point, applied to the regular normal.
Eigen::Vector3d SurfaceNormal(const Geon& geon, const Eigen::Vector3d& regular);

// Throws std::invalid_argument, saying which, if a parameter is not finite or out of its range.
void CheckGeon(const Geon& geon);

}  // namespace geond
