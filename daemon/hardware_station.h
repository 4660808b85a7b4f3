// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "daemon/config.h"
#include "daemon/station.h"
#include "drivers/gpio_lines.h"
#include "drivers/modbus_turntable.h"
#include "drivers/u3v_rangefinder.h"

namespace geond::daemon {

// What the configuration says of each device, in the terms of its driver. All throw ConfigError naming the key.
drivers::U3vRangefinderOptions RangefinderOptions(const Config& config);
drivers::ModbusTurntableOptions TurntableOptions(const Config& config);  // and FileError, if there is no such profile
drivers::GpioLinesOptions LinesOptions(const Config& config);
// A wire as the configuration writes it: "!LASER_EN", "17"; absent if empty. `key` is for errors.
std::optional<drivers::GpioWire> ParseWire(const Config& config, const std::string& key, const std::string& text);

// The station of real devices. Those that cannot be had now are absent or faulted, say why, and are tried again by
// Station::Reset. Throws ConfigError, FileError (calibration, drive profile).
std::unique_ptr<Station> OpenHardwareStation(const Config& config, StationOptions options);

// Laser and motor off and the camera's stream ended, device by device, whatever state a dead service left them in.
// Returns what did not work, in words.
std::vector<std::string> SwitchHardwareOff(const Config& config);

}  // namespace geond::daemon
