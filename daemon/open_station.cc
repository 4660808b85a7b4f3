// SPDX-License-Identifier: Apache-2.0
#include "daemon/open_station.h"

#include "daemon/hardware_station.h"
#include "sim/sim_config.h"
#include "sim/sim_devices.h"

namespace geond::daemon {

std::unique_ptr<Station> SimulatedStation(const std::shared_ptr<sim::SimStation>& world, StationOptions options) {
  StationDevices devices;
  devices.world = world;
  devices.rangefinder = std::make_unique<sim::SimRangefinder>(
      world, options.trigger == StationOptions::Trigger::kWire ? sim::SimRangefinder::TriggerSource::kWire
                                                               : sim::SimRangefinder::TriggerSource::kSoftware);
  devices.turntable = std::make_unique<sim::SimTurntable>(world);
  devices.lines = std::make_unique<sim::SimLines>(world);
  return std::make_unique<Station>(std::move(devices), world->options().assumed, options);
}

OpenedStation OpenStation(const Config& config) {
  StationOptions options;
  options.frame_timeout = std::chrono::milliseconds(config.frame_timeout_ms);
  options.trigger = config.station_trigger == "wire" ? StationOptions::Trigger::kWire : StationOptions::Trigger::kSoftware;
  if (config.station_kind == "hardware") return {OpenHardwareStation(config, options), nullptr};
  const sim::SimConfig simulation = sim::ReadSimConfig(config.folder / config.station_simulation);
  OpenedStation opened;
  opened.simulation = sim::OpenSimStation(
      simulation, config.station_scene.empty() ? std::filesystem::path() : config.folder / config.station_scene);
  opened.station = SimulatedStation(opened.simulation, options);
  return opened;
}

}  // namespace geond::daemon
