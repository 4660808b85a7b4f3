// SPDX-License-Identifier: Apache-2.0
// Whatever a configuration says: taken, and then the same when written and read again, or a named error.
#include <cstdint>
#include <string>

#include "core/base/error.h"
#include "daemon/config.h"
#include "tests/fuzz/check.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace geond::daemon;
  const std::string text(reinterpret_cast<const char*>(data), size);
  try {
    const Config config = ParseConfig(text, "fuzz");
    Check(ParseConfig(ConfigText(config), "again") == config);
  } catch (const geond::ConfigError&) {
  }
  return 0;
}
