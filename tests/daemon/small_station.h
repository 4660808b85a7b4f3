// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "daemon/open_station.h"
#include "daemon/rpc.h"
#include "sim/sim_devices.h"
#include "sim/sim_station.h"
#include "tests/daemon/temporary_folder.h"

namespace geond::daemon {

// An ellipsoid that stands on the table.
inline sim::Scene Egg() {
  sim::Scene scene;
  scene.name = "egg";
  Geon egg;
  egg.type = GeonType::kEllipsoid;
  egg.size = {0.030, 0.030, 0.045};
  egg.X_TG = Pose::Translation({0.0, 0.0, 0.045});
  scene.parts.push_back({"egg", egg});
  return scene;
}

// A world with the egg and a small camera, in which nothing ever sleeps.
inline std::shared_ptr<sim::SimStation> SmallWorld(int pixels = 64) {
  sim::StationOptions options;
  options.assumed = sim::MakeStation(0.450, 0.489, 0.045, pixels, pixels, 0.16);
  return std::make_shared<sim::SimStation>(Egg(), options);
}

// The same without any noise.
inline std::shared_ptr<sim::SimStation> NoiselessWorld(int pixels) {
  sim::StationOptions options;
  options.assumed = sim::MakeStation(0.450, 0.489, 0.045, pixels, pixels, 0.16, 0.0);
  options.camera = sim::CameraOptions::Perfect();
  options.turntable.angle_noise = options.turntable.angle_resolution = options.turntable.backlash = 0.0;
  return std::make_shared<sim::SimStation>(Egg(), options);
}

inline OpenedStation SmallStation(const std::shared_ptr<sim::SimStation>& world) {
  return {SimulatedStation(world, {}), world};
}

// A request as a client writes it.
inline std::string Request(const std::string& method, const Json& params) {
  return Json{{"jsonrpc", "2.0"}, {"id", 1}, {"method", method}, {"params", params}}.dump();
}

}  // namespace geond::daemon
