// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "daemon/config.h"
#include "daemon/station.h"
#include "sim/sim_station.h"

namespace geond::daemon {

// The station that a configuration describes. `simulation` is the world of a simulated one, else empty.
struct OpenedStation {
  std::unique_ptr<Station> station;
  std::shared_ptr<sim::SimStation> simulation;
};

// Opens the devices of the configured station. A device of real hardware that cannot be had is absent or faulted, says
// why, and is tried again by Station::Reset. Throws ConfigError, FileError.
OpenedStation OpenStation(const Config& config);

// The simulated devices of a world as a station.
std::unique_ptr<Station> SimulatedStation(const std::shared_ptr<sim::SimStation>& world, StationOptions options);

}  // namespace geond::daemon
