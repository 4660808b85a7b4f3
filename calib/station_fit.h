// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "calib/calibrate.h"
#include "calib/target_sphere.h"

namespace geond::calib {

// The sightings of one placement of a sphere.
struct SightedPlacement {
  double radius = 0.0;  // m
  std::vector<TargetSighting> sightings;
};

// What the joint solve found. Parameters of the sensor: depth scale less 1, depth offset (m), relative corrections of the
// focal lengths in u and v.
struct StationFit {
  Pose X_ST;                             // table at angle 0, in the sensor's frame
  std::array<double, 4> sensor{};
  std::vector<Eigen::Vector3d> centers_T;  // of the sphere, a placement
  std::array<double, 2> plate{};         // slopes of the table top in T
  double rms = 0.0;                      // m, robust, of the sphere's returns
  double axis_direction_sigma = 0.0, axis_position_sigma = 0.0, scale_sigma = 0.0;
  bool known = false;                    // the covariance exists: every parameter is determined
  SolveSummary summary;
};

// Joint least squares (Ceres) over all returns of spheres and table, starting from X_ST.
StationFit SolveStation(const SensorModel& sensor, const Pose& X_ST, const std::vector<SightedPlacement>& placements,
                        const CalibrateOptions& options);

// A return in S by the corrected sensor.
Eigen::Vector3d CorrectedPoint(const SensorModel& sensor, const std::array<double, 4>& correction, const RawReturn& raw);

}  // namespace geond::calib
