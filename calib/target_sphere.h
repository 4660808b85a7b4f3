// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "core/range/range_image.h"
#include "core/range/scan_folder.h"

namespace geond::calib {

// A return as the sensor gives it: pixel and depth (m).
struct RawReturn {
  double column = 0.0, row = 0.0, depth = 0.0;
};

// What one exposure shows of a sphere of known size and of the table under it.
struct TargetSighting {
  double table_angle = 0.0;          // rad
  Eigen::Vector3d center_S;          // m, by the sensor model as it was assumed
  std::vector<RawReturn> sphere;     // returns on it, evenly drawn, none grazing
  std::vector<RawReturn> table;
  double rms = 0.0;                  // m, of the sphere's returns
};

// Finds the sphere in an exposure of the station as calibrated so far (which may be off by degrees and millimetres). None
// if no surface in the work space fits a sphere of that radius (m).
std::optional<TargetSighting> FindTarget(const Exposure& exposure, const StationGeometry& station, double radius);

// Least squares centre and radius of points; the radius is kept if `radius` > 0. Robust against outliers beyond a few rms.
struct SphereFit {
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  double radius = 0.0;
  double rms = 0.0;
};
SphereFit FitSphere(const std::vector<Eigen::Vector3d>& points, const Eigen::Vector3d& start, double radius);

}  // namespace geond::calib
