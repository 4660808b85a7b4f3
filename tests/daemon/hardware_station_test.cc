// SPDX-License-Identifier: Apache-2.0
// From what a configuration says to what the drivers are told; the devices themselves are in tests/system.
#include "daemon/hardware_station.h"

#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"

namespace geond::daemon {
namespace {

using testing::HasSubstr;

Config Hardware() {
  Config config;
  config.folder = std::string(GEOND_SOURCE_DIR) + "/config";
  config.station_kind = "hardware";
  return config;
}

template <typename Call>
std::string ErrorOf(const Call& call) {
  try {
    call();
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "no error";
}

TEST(HardwareStation, TheDefaultsAreAStation) {
  const Config config = Hardware();
  const auto table = TurntableOptions(config);
  EXPECT_EQ(table.profile.name, "Oriental Motor BLV-R");
  EXPECT_EQ(table.address.serial_device, "/dev/ttyUSB0");
  EXPECT_EQ(table.address.baud, 230400);  // by the profile
  EXPECT_EQ(table.address.parity, 'E');
  EXPECT_NEAR(table.speed, 30.0 * std::numbers::pi / 180.0, 1e-12);
  const auto lines = LinesOptions(config);
  EXPECT_EQ(lines.laser.offset, 0u);
  EXPECT_TRUE(lines.emergency_stop.active_low);
  EXPECT_FALSE(lines.trigger);
  EXPECT_EQ(RangefinderOptions(config).trigger, drivers::U3vRangefinderOptions::Trigger::kSoftware);
}

TEST(HardwareStation, KeysReachTheirDrivers) {
  Config config = Hardware();
  for (const char* setting :
       {"turntable.serial=", "turntable.host=192.168.1.20", "turntable.port=1502", "turntable.unit=9",
        "turntable.parity=none", "turntable.baud=9600", "turntable.gear_ratio=-18", "turntable.tolerance_deg=0.1",
        "turntable.max_angle_deg=360", "lines.laser=!LASER_EN", "lines.motor=", "lines.trigger=27",
        "lines.input_bias=pull_down", "lines.trigger_pulse_us=20", "station.trigger=wire",
        "rangefinder.trigger_line=Line2", "rangefinder.exposure_us=1500"}) {
    SetConfigKey(config, setting);
  }
  const auto table = TurntableOptions(config);
  EXPECT_EQ(table.address.host, "192.168.1.20");
  EXPECT_EQ(table.address.port, 1502);
  EXPECT_EQ(table.address.unit, 9);
  EXPECT_EQ(table.address.parity, 'N');
  EXPECT_EQ(table.address.baud, 9600);
  EXPECT_EQ(table.gear_ratio, -18.0);
  EXPECT_NEAR(table.max_angle, 2.0 * std::numbers::pi, 1e-12);
  const auto lines = LinesOptions(config);
  EXPECT_EQ(lines.laser.line, "LASER_EN");
  EXPECT_TRUE(lines.laser.active_low);
  EXPECT_FALSE(lines.motor);
  EXPECT_EQ(lines.trigger->offset, 27u);
  EXPECT_EQ(lines.door->bias, drivers::GpioWire::Bias::kPullDown);
  EXPECT_EQ(lines.trigger_pulse.count(), 20);
  const auto camera = RangefinderOptions(config);
  EXPECT_EQ(camera.trigger, drivers::U3vRangefinderOptions::Trigger::kWire);
  EXPECT_EQ(camera.trigger_line, "Line2");
  EXPECT_EQ(camera.exposure_us, 1500.0);
}

TEST(HardwareStation, WhatDoesNotGoTogetherNamesTheKey) {
  const auto with = [](const char* setting) {
    Config config = Hardware();
    SetConfigKey(config, setting);
    return config;
  };
  EXPECT_THAT(ErrorOf([&] { TurntableOptions(with("turntable.host=10.0.0.1")); }), HasSubstr("turntable.serial"));
  EXPECT_THAT(ErrorOf([&] { TurntableOptions(with("turntable.serial=")); }), HasSubstr("turntable.host"));
  EXPECT_THAT(ErrorOf([&] { TurntableOptions(with("turntable.gear_ratio=0")); }), HasSubstr("turntable.gear_ratio"));
  EXPECT_THAT(ErrorOf([&] { TurntableOptions(with("turntable.min_angle_deg=1000000")); }),
              HasSubstr("turntable.min_angle_deg"));
  EXPECT_THAT(ErrorOf([&] { LinesOptions(with("lines.laser=")); }), HasSubstr("lines.laser"));
  EXPECT_THAT(ErrorOf([&] { LinesOptions(with("lines.emergency_stop=!")); }), HasSubstr("names no line"));
  EXPECT_THAT(ErrorOf([&] { LinesOptions(with("station.trigger=wire")); }), HasSubstr("lines.trigger"));
  EXPECT_THAT(ErrorOf([&] { OpenHardwareStation(Hardware(), {}); }), HasSubstr("station.calibration"));
}

}  // namespace
}  // namespace geond::daemon
