// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "daemon/command/service_commands.h"

namespace geond::daemon {

struct CalibrateArguments : ServiceArguments {
  double target = 0.040, check = 0.060;  // m, diameters of the two spheres
  int placements = 3;                    // of the target
  int views = 8;                         // a placement
  bool show = false, list = false;       // only say which is in force, or all there are
  std::optional<int> use;                // go back to this one; 0: the station as configured
  std::vector<std::filesystem::path> target_scans, check_scans;  // recorded scans: solve these, without a service
  std::filesystem::path output;          // of what recorded scans give; empty: none
};

// Guides a person through the calibration of the station (on the simulated one the spheres come by themselves), or solves
// recorded scans of the spheres. What is rejected exits 1, with the reasons. Throws as the other commands do.
CommandResult Calibrate(const CalibrateArguments& arguments, const CommandContext& context);

}  // namespace geond::daemon
