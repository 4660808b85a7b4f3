// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "calib/station_fit.h"

namespace geond::calib {

// How far the sphere's centre, fitted in each image alone, lies from where axis and table angle put it.
struct PathCheck {
  double rms = 0.0;    // m
  std::string reason;  // what moved, if anything did: the target between two images, or the axis with the angle
};
PathCheck CheckPaths(const SensorModel& sensor, const StationFit& fit, const std::vector<SightedPlacement>& placements);

}  // namespace geond::calib
