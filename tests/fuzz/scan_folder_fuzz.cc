// SPDX-License-Identifier: Apache-2.0
// Any bytes as scan.json (even first byte) or as a range image (odd): read, or refused by a FileError; what was read is
// written and read again.
#include <cstdint>
#include <cstdlib>
#include <span>
#include <string>

#include "core/base/error.h"
#include "core/range/depth_image_file.h"
#include "core/range/scan_json.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::span<const std::uint8_t> bytes(data + 1, size - 1);
  try {
    if (data[0] % 2 == 1) {
      const geond::RangeImage image = geond::DecodeDepthPng(bytes, 8, 6, {1e-5, 0.4}, "a.png");
      if (image.depth.size() != 48) std::abort();
    } else {
      const geond::ScanDocument document = geond::ScanFromJson({bytes.begin(), bytes.end()}, "scan.json");
      const geond::ScanDocument again = geond::ScanFromJson(geond::ScanToJson(document), "scan.json");
      if (again.scan.views.size() != document.scan.views.size()) std::abort();
    }
  } catch (const geond::FileError&) {
  }
  return 0;
}
