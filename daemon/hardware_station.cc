// SPDX-License-Identifier: Apache-2.0
#include "daemon/hardware_station.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numbers>

#include <spdlog/spdlog.h>

#include "calib/calibration_file.h"
#include "core/base/error.h"
#include "drivers/libusb_port.h"

namespace geond::daemon {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

[[noreturn]] void Fail(const std::string& key, const std::string& cause, const std::string& remedy) {
  throw ConfigError("geond.toml", key, cause, remedy);
}

calib::StationCalibration Calibration(const Config& config) {
  if (config.station_calibration.empty()) {
    Fail("station.calibration", "it is empty, and a hardware station must know where its devices stand",
         "Calibrate the station and name the file here");
  }
  return calib::ReadCalibration(config.folder / config.station_calibration);
}

char Parity(const std::string& word, char by_profile) {
  if (word == "profile") return by_profile;
  return word == "none" ? 'N' : word == "odd" ? 'O' : 'E';
}

drivers::GpioWire::Bias Bias(const std::string& word) {
  using Bias = drivers::GpioWire::Bias;
  if (word == "none") return Bias::kNone;
  if (word == "pull_up") return Bias::kPullUp;
  return word == "pull_down" ? Bias::kPullDown : Bias::kAsIs;
}

}  // namespace

drivers::U3vRangefinderOptions RangefinderOptions(const Config& config) {
  drivers::U3vRangefinderOptions options;
  options.trigger = config.station_trigger == "wire" ? drivers::U3vRangefinderOptions::Trigger::kWire
                                                     : drivers::U3vRangefinderOptions::Trigger::kSoftware;
  options.trigger_line = config.rangefinder_trigger_line;
  options.pixel_format = config.rangefinder_pixel_format;
  if (config.rangefinder_exposure_us > 0.0) options.exposure_us = config.rangefinder_exposure_us;
  options.may_be_absent = true;
  return options;
}

drivers::ModbusTurntableOptions TurntableOptions(const Config& config) {
  drivers::ModbusTurntableOptions options;
  options.profile = drivers::ReadDriveProfile(config.folder / config.turntable_profile);
  options.address.serial_device = config.turntable_serial;
  options.address.host = config.turntable_host;
  if (config.turntable_serial.empty() == config.turntable_host.empty()) {
    Fail("turntable.serial", "exactly one of turntable.serial and turntable.host must be given",
         "Name the port or the address that the drive is on, and leave the other empty");
  }
  options.address.port = config.turntable_port;
  options.address.unit = config.turntable_unit;
  options.address.baud = config.turntable_baud > 0 ? config.turntable_baud : options.profile.baud;
  options.address.parity = Parity(config.turntable_parity, options.profile.parity);
  options.address.stop_bits = options.profile.stop_bits;
  options.address.response_timeout = options.address.probe_timeout = std::chrono::milliseconds(config.turntable_response_ms);
  if (std::abs(config.turntable_gear_ratio) < 1e-3)
    Fail("turntable.gear_ratio", "it is zero", "Give turns of the motor a turn of the table");
  options.gear_ratio = config.turntable_gear_ratio;
  options.speed = kDegree * config.turntable_speed_deg_per_s;
  options.acceleration = kDegree * config.turntable_acceleration_deg_per_s2;
  options.tolerance = kDegree * config.turntable_tolerance_deg;
  options.settle_time = std::chrono::milliseconds(config.turntable_settle_ms);
  options.min_angle = kDegree * config.turntable_min_angle_deg;
  options.max_angle = kDegree * config.turntable_max_angle_deg;
  if (options.min_angle >= options.max_angle) {
    Fail("turntable.min_angle_deg", "it is not below turntable.max_angle_deg", "Leave a range to turn in");
  }
  return options;
}

std::optional<drivers::GpioWire> ParseWire(const Config& config, const std::string& key, const std::string& text) {
  if (text.empty()) return std::nullopt;
  drivers::GpioWire wire;
  wire.chip = config.lines_chip;
  wire.active_low = text.front() == '!';
  const std::string line = wire.active_low ? text.substr(1) : text;
  if (line.empty()) Fail(key, "it names no line", "Give a line's number or name, or leave it empty");
  const auto [end, error] = std::from_chars(line.data(), line.data() + line.size(), wire.offset);
  if (error != std::errc() || end != line.data() + line.size()) wire.line = line;
  return wire;
}

drivers::GpioLinesOptions LinesOptions(const Config& config) {
  drivers::GpioLinesOptions options;
  const auto needed = [&](const char* key, const std::string& text) {
    const auto wire = ParseWire(config, key, text);
    if (!wire) Fail(key, "it is empty, and no station may run without it", "Name the line that it is on");
    return *wire;
  };
  options.laser = needed("lines.laser", config.lines_laser);
  options.emergency_stop = needed("lines.emergency_stop", config.lines_emergency_stop);
  options.motor = ParseWire(config, "lines.motor", config.lines_motor);
  options.lamp = ParseWire(config, "lines.lamp", config.lines_lamp);
  options.trigger = ParseWire(config, "lines.trigger", config.lines_trigger);
  options.door = ParseWire(config, "lines.door", config.lines_door);
  if (config.station_trigger == "wire" && !options.trigger) {
    Fail("lines.trigger", "it is empty, and station.trigger is \"wire\"", "Name its line, or trigger by software");
  }
  options.emergency_stop.bias = Bias(config.lines_input_bias);
  if (options.door) options.door->bias = Bias(config.lines_input_bias);
  options.trigger_pulse = std::chrono::microseconds(config.lines_trigger_pulse_us);
  options.debounce = std::chrono::milliseconds(config.lines_debounce_ms);
  options.may_be_absent = true;
  return options;
}

std::unique_ptr<Station> OpenHardwareStation(const Config& config, StationOptions options) {
  const calib::StationCalibration calibration = Calibration(config);
  if (calibration.depth_scale != 1.0 || calibration.depth_offset != 0.0) options.calibration = calibration;
  drivers::U3vRangefinderOptions rangefinder = RangefinderOptions(config);
  rangefinder.sensor = calibration.station.sensor;
  const drivers::ModbusTurntableOptions turntable = TurntableOptions(config);
  StationDevices devices;
  try {
    devices.lines = std::make_unique<drivers::GpioLines>(LinesOptions(config));
  } catch (const std::invalid_argument& error) {
    Fail("lines", error.what(), "Give each wire a line of its own");
  }
  devices.turntable = std::make_unique<drivers::ModbusTurntable>(turntable);
  devices.rangefinder =
      std::make_unique<drivers::U3vRangefinder>(drivers::LibusbCamera(config.rangefinder_identity), rangefinder);
  try {
    devices.turntable->Reset();
  } catch (const DeviceError&) {
    // Its info() says why.
  }
  auto station = std::make_unique<Station>(std::move(devices), calibration.station, options);
  for (const drivers::DeviceInfo& device : station->devices()) {
    if (device.fault.empty()) {
      spdlog::info("{}: {} {}", device.name, device.model, device.serial);
    } else {
      spdlog::warn("{} is {}: {}", device.name, drivers::DeviceStateName(device.state), device.fault);
    }
  }
  return station;
}

std::vector<std::string> SwitchHardwareOff(const Config& config) {
  std::vector<std::string> failures;
  const auto attempt = [&](const auto& work) {
    try {
      work();
    } catch (const std::exception& error) {
      failures.push_back(error.what());
    }
  };
  attempt([&] {
    drivers::GpioLinesOptions options = LinesOptions(config);
    options.may_be_absent = false;
    drivers::GpioLines(options).AllOff();
  });
  attempt([&] {
    drivers::ModbusTurntable turntable(TurntableOptions(config));
    turntable.angle();  // opens the line and finds out whether it is in order
    turntable.Halt();
    turntable.Disable();
  });
  attempt([&] {
    drivers::U3vRangefinderOptions options = RangefinderOptions(config);
    options.may_be_absent = false;
    options.sensor = SensorModel{};  // what it sees does not matter here
    drivers::U3vRangefinder(drivers::LibusbCamera(config.rangefinder_identity), options).Disarm();
  });
  return failures;
}

}  // namespace geond::daemon
