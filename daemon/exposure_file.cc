// SPDX-License-Identifier: Apache-2.0
// Layout, little-endian: magic "GEONDEX1", int32 columns, int32 rows, double table_angle (rad), int64 timestamp (ns),
// float depth[columns * rows], uint64 FNV-1a sum of everything before it.
#include "daemon/exposure_file.h"

#include <bit>
#include <cstdint>
#include <cstring>

#include "core/base/error.h"

namespace geond::daemon {
namespace {

static_assert(std::endian::native == std::endian::little, "exposures are stored as they lie in memory");

constexpr std::string_view kMagic = "GEONDEX1";
constexpr std::size_t kHeader = 8 + 4 + 4 + 8 + 8;

std::uint64_t Sum(std::string_view bytes) {
  std::uint64_t sum = 0xcbf29ce484222325u;
  for (const char byte : bytes) sum = (sum ^ static_cast<unsigned char>(byte)) * 0x100000001b3u;
  return sum;
}

template <typename T>
void Append(std::string& bytes, const T& value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

template <typename T>
T At(std::string_view bytes, std::size_t offset) {
  T value;
  std::memcpy(&value, bytes.data() + offset, sizeof value);
  return value;
}

}  // namespace

std::string EncodeExposure(const Exposure& exposure) {
  std::string bytes(kMagic);
  Append(bytes, std::int32_t{exposure.image.columns});
  Append(bytes, std::int32_t{exposure.image.rows});
  Append(bytes, exposure.table_angle);
  Append(bytes, std::int64_t{exposure.timestamp.count()});
  bytes.append(reinterpret_cast<const char*>(exposure.image.depth.data()), exposure.image.depth.size() * sizeof(float));
  Append(bytes, Sum(bytes));
  return bytes;
}

Exposure DecodeExposure(std::string_view bytes, const std::string& name) {
  if (bytes.size() < kHeader + 8 || bytes.substr(0, kMagic.size()) != kMagic) {
    throw FileError(name, "read", "it is no stored exposure (" + std::to_string(bytes.size()) + " bytes)");
  }
  Exposure exposure;
  exposure.image.columns = At<std::int32_t>(bytes, 8);
  exposure.image.rows = At<std::int32_t>(bytes, 12);
  exposure.table_angle = At<double>(bytes, 16);
  exposure.timestamp = std::chrono::nanoseconds(At<std::int64_t>(bytes, 24));
  const std::size_t pixels = (bytes.size() - kHeader - 8) / sizeof(float);
  if (exposure.image.columns < 1 || exposure.image.rows < 1 ||
      static_cast<std::size_t>(exposure.image.columns) * static_cast<std::size_t>(exposure.image.rows) != pixels ||
      bytes.size() != kHeader + 8 + pixels * sizeof(float)) {
    throw FileError(name, "read", "its length is not that of its image");
  }
  if (At<std::uint64_t>(bytes, bytes.size() - 8) != Sum(bytes.substr(0, bytes.size() - 8))) {
    throw FileError(name, "check", "its sum is wrong: the file was damaged");
  }
  exposure.image.depth.resize(pixels);
  std::memcpy(exposure.image.depth.data(), bytes.data() + kHeader, pixels * sizeof(float));
  return exposure;
}

}  // namespace geond::daemon
