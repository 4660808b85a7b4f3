// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <memory>

#include "sim/sim_station.h"

namespace geond::sim {

// The simulated station as config/sim.toml describes it.
struct SimConfig {
  std::filesystem::path scene_file;  // absolute, or below the folder of the configuration
  StationOptions station;
  std::map<Device, Fault> faults;  // from the start
};

// Every key has a default; `path` empty: all defaults. Throws FileError, ConfigError naming file, line and key.
SimConfig ReadSimConfig(const std::filesystem::path& path);

// The station that it describes, with its scene read and its faults set. Another scene file may be given.
std::shared_ptr<SimStation> OpenSimStation(const SimConfig& config, const std::filesystem::path& scene_file = {});

}  // namespace geond::sim
