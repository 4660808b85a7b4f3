// SPDX-License-Identifier: Apache-2.0
#include "drivers/rangefinder.h"

namespace geond::drivers {

std::string_view DeviceStateName(DeviceState state) {
  switch (state) {
    case DeviceState::kAbsent: return "absent";
    case DeviceState::kIdle: return "idle";
    case DeviceState::kArmed: return "armed";
    case DeviceState::kFault: return "fault";
  }
  return "unknown";
}

}  // namespace geond::drivers
