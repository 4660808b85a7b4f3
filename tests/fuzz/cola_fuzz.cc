// SPDX-License-Identifier: Apache-2.0
// Whatever a line scanner sends, however it is cut: telegrams and lines or a named rule, never a crash.
#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "drivers/cola.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace geond::drivers;
  if (size == 0) return 0;
  const std::size_t part = 1 + data[0];
  cola::Bytes stream;
  int broken = 0;
  for (std::size_t at = 1; at < size; at += part) {
    stream.insert(stream.end(), data + at, data + std::min(size, at + part));
    while (const auto telegram = cola::TakeTelegram(stream, broken)) {
      cola::ErrorReply(*telegram);
      std::string error;
      const auto line = cola::DecodeScanLine(*telegram, error);
      if (!line && error.empty()) std::abort();
      if (!line) continue;
      if (line->range.empty() || (!line->remission.empty() && line->remission.size() != line->range.size()))
        std::abort();
      if (!cola::DecodeScanLine(cola::EncodeScanLine(*line, telegram->protocol), error)) std::abort();
    }
  }
  return 0;
}
