// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <string_view>

namespace geond::sim {

// What can be wrong with a device, by one word each. The devices say in sim_devices.h how each shows.
enum class Fault { kNone, kOff, kStuck, kGarbage, kWrong, kSlow, kDelayed, kIntermittent };
inline constexpr std::array kFaults = {Fault::kOff,  Fault::kStuck,   Fault::kGarbage,     Fault::kWrong,
                                       Fault::kSlow, Fault::kDelayed, Fault::kIntermittent};
enum class Device { kRangefinder, kTurntable, kLines };
inline constexpr std::array kDevices = {Device::kRangefinder, Device::kTurntable, Device::kLines};

// "none", "off", "stuck", "garbage", "wrong", "slow", "delayed", "intermittent".
std::string_view FaultName(Fault fault);
// "rangefinder", "turntable", "lines".
std::string_view DeviceName(Device device);
// Throw std::invalid_argument, listing the words, if there is no such word.
Fault FaultFromName(std::string_view name);
Device DeviceFromName(std::string_view name);

}  // namespace geond::sim
