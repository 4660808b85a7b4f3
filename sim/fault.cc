// SPDX-License-Identifier: Apache-2.0
#include "sim/fault.h"

#include <span>
#include <stdexcept>
#include <string>

namespace geond::sim {
namespace {

constexpr std::array<std::string_view, 8> kFaultNames = {"none",  "off",  "stuck",   "garbage",
                                                         "wrong", "slow", "delayed", "intermittent"};
constexpr std::array<std::string_view, 3> kDeviceNames = {"rangefinder", "turntable", "lines"};

std::size_t Find(std::span<const std::string_view> names, std::string_view name, const std::string& what) {
  std::string list;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (names[i] == name) return i;
    list += (i ? ", " : "") + std::string(names[i]);
  }
  throw std::invalid_argument("\"" + std::string(name) + "\" is no " + what + "; known are: " + list);
}

}  // namespace

std::string_view FaultName(Fault fault) { return kFaultNames[static_cast<std::size_t>(fault)]; }
std::string_view DeviceName(Device device) { return kDeviceNames[static_cast<std::size_t>(device)]; }
Fault FaultFromName(std::string_view name) { return static_cast<Fault>(Find(kFaultNames, name, "fault")); }
Device DeviceFromName(std::string_view name) { return static_cast<Device>(Find(kDeviceNames, name, "device")); }

}  // namespace geond::sim
