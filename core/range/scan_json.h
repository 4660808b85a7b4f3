// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/range/depth_image_file.h"
#include "core/range/scan_folder.h"

namespace geond {

inline constexpr int kScanFormatVersion = 1;
inline constexpr std::int64_t kMaxImageSide = 32768;
inline constexpr std::int64_t kMaxImagePixels = std::int64_t{1} << 25;

// How the range image of a view lies in the scan's folder.
struct ScanImageEntry {
  std::string file;  // a plain name
  bool png = false;  // grey 16-bit PNG by `code`, else raw floats
  DepthCode code;
  std::string sha256;  // 64 hexadecimal digits, lower case
};

// What scan.json says: the scan without its pictures, and where these are.
struct ScanDocument {
  RecordedScan scan;                   // images empty, truth empty
  std::vector<ScanImageEntry> images;  // one a view
  std::optional<std::string> truth_file;
  std::string truth_sha256;
};

// The text of scan.json, lengths in mm, angles in degrees, and back. Reading throws FileError naming `file` and the key
// of whatever is missing, of the wrong kind or out of range.
std::string ScanToJson(const ScanDocument& document);
ScanDocument ScanFromJson(const std::string& text, const std::string& file);

}  // namespace geond
