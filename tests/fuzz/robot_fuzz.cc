// SPDX-License-Identifier: Apache-2.0
// Whatever line a robot says, and whatever a configuration says of who may ask.
#include <cstdint>
#include <stdexcept>
#include <string>

#include "daemon/robot/allow_list.h"
#include "daemon/robot/robot_protocol.h"
#include "tests/fuzz/check.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace geond::daemon;
  const std::string text(reinterpret_cast<const char*>(data), size);
  const auto request = ParseRobotRequest(text);
  Check(!request || (request->number >= 0 && request->number <= 999 && text.size() <= kMaxRobotLine));
  try {
    AllowList(text).Contains(text);
  } catch (const std::invalid_argument&) {
  }
  return 0;
}
