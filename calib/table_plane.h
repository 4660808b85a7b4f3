// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include <Eigen/Core>

namespace geond::calib {

// The table top in T: height(p) = normal . p - offset, near z = 0 where the calibration puts it.
struct TablePlane {
  Eigen::Vector3d normal_T = Eigen::Vector3d::UnitZ();
  double offset = 0.0;   // m
  int returns = 0;       // that lie on it
  double rms = 0.0;      // of their heights, m
  bool refined = false;  // false: too few returns, or no plane near z = 0; the calibrated plane stands

  double Height(const Eigen::Vector3d& p_T) const { return normal_T.dot(p_T) - offset; }
  double Tilt() const;  // rad, against z
};

struct TablePlaneOptions {
  double max_height = 0.008;   // m: the table lies at most so far from z = 0 at the axis, ...
  double max_tilt = 0.035;     // rad: ... and is tilted at most so much; returns beyond what both allow are not asked
  double noise = 0.0;          // standard deviation of a height, m; 0: taken as 0.2 mm
  int min_returns = 200;       // fewer on the plane: not refined
  double lower_share = 0.15;   // a lower plane with this share of the returns asked is the table, the upper one an object
};

// The plane of the table's returns among `points_T`: consensus of three points (own generator, fixed seed), then least
// squares on the returns that agree. Where they lie along a line only, the height alone is refined.
TablePlane FitTablePlane(const std::vector<Eigen::Vector3d>& points_T, const TablePlaneOptions& options = {});

}  // namespace geond::calib
