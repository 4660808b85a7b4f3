// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "daemon/open_station.h"
#include "sim/sim_devices.h"
#include "sim/sim_station.h"
#include "tests/daemon/temporary_folder.h"

namespace geond::daemon {

// A world with an ellipsoid on the table and a small camera, in which nothing ever sleeps.
inline std::shared_ptr<sim::SimStation> SmallWorld(int pixels = 64) {
  sim::Scene scene;
  scene.name = "egg";
  Geon egg;
  egg.type = GeonType::kEllipsoid;
  egg.size = {0.030, 0.030, 0.045};
  egg.X_TG = Pose::Translation({0.0, 0.0, 0.045});
  scene.parts.push_back({"egg", egg});
  sim::StationOptions options;
  options.assumed = sim::MakeStation(0.450, 0.489, 0.045, pixels, pixels, 0.16);
  return std::make_shared<sim::SimStation>(scene, options);
}

inline OpenedStation SmallStation(const std::shared_ptr<sim::SimStation>& world) {
  return {SimulatedStation(world, {}), world};
}

}  // namespace geond::daemon
