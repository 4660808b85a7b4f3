// SPDX-License-Identifier: Apache-2.0
#include "drivers/u3v_depth.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include "core/base/error.h"

namespace geond::drivers::u3v {
namespace {

static_assert(std::endian::native == std::endian::little, "numbers are copied as they are on the wire");

float DepthOf(double value, const DepthScale& scale) {
  const double depth = (value * scale.scale + scale.offset) * scale.metres;
  const bool none = (scale.invalid && value == *scale.invalid) || !std::isfinite(depth) || depth <= 0.0;
  return none ? std::numeric_limits<float>::quiet_NaN() : static_cast<float>(depth);
}

// The depths of one row's numbers, from a table of all. By the processor's gather instructions where it has them.
[[gnu::target_clones("avx512f", "avx2", "default")]] void LookUp(const std::uint16_t* __restrict numbers, std::size_t count,
                                                                 const float* __restrict table, float* __restrict depths) {
  for (std::size_t i = 0; i < count; ++i) depths[i] = table[numbers[i]];
}

struct Census {
  std::uint32_t finite = 0, outside = 0;
};

[[gnu::target_clones("avx2", "default")]] Census Count(const float* depths, std::size_t count, float least, float greatest) {
  Census census;
  for (std::size_t i = 0; i < count; ++i) {
    census.finite += depths[i] == depths[i] ? 1 : 0;
    census.outside += (depths[i] < least) | (depths[i] > greatest) ? 1 : 0;
  }
  return census;
}

// Row by row, each looked at while it is at hand. Depth is the last of a pixel's `pixel` bytes.
template <typename Number, typename ToDepths>
RangeImage Decode(const Frame& frame, std::size_t pixel, const ToDepths& to_depths, const DepthRange& range) {
  const std::size_t columns = frame.leader.width, row_size = columns * pixel + frame.leader.padding_x;
  const auto least = static_cast<float>(range.least), greatest = static_cast<float>(range.greatest);
  RangeImage image;
  image.columns = static_cast<int>(columns);
  image.rows = static_cast<int>(frame.trailer.height);
  image.depth.reserve(columns * frame.trailer.height);
  std::vector<Number> numbers(columns);
  std::vector<float> depths(columns);
  std::uint64_t finite = 0, outside = 0;
  for (std::size_t row = 0; row < frame.trailer.height; ++row) {
    const std::uint8_t* bytes = frame.payload.data() + row * row_size + pixel - sizeof(Number);
    if (pixel == sizeof(Number)) {
      std::memcpy(numbers.data(), bytes, columns * pixel);
    } else {
      for (std::size_t i = 0; i < columns; ++i) std::memcpy(&numbers[i], bytes + i * pixel, sizeof(Number));
    }
    to_depths(numbers, depths);
    const Census census = Count(depths.data(), columns, least, greatest);
    finite += census.finite;
    outside += census.outside;
    image.depth.insert(image.depth.end(), depths.begin(), depths.end());
  }
  if (2 * outside > finite) {
    throw DeviceError("camera", "read image",
                      std::to_string(outside) + " of " + std::to_string(finite) +
                          " depths are far out of the camera's own range",
                      "Check the cable and the camera's settings, then reset the station");
  }
  return image;
}

}  // namespace

RangeImage DecodeDepth(const Frame& frame, const DepthScale& scale, const DepthRange& range) {
  const auto format = static_cast<PixelFormat>(frame.leader.pixel_format);
  const std::size_t pixel = BytesPerPixel(frame.leader.pixel_format);
  const bool is_float = format == PixelFormat::kCoord3dC32f || format == PixelFormat::kCoord3dAbc32f;
  const auto one_by_one = [&](const auto& numbers, std::vector<float>& depths) {
    std::ranges::transform(numbers, depths.begin(), [&](auto number) { return DepthOf(number, scale); });
  };
  if (is_float) return Decode<float>(frame, pixel, one_by_one, range);
  // A large image has more pixels than there are numbers of 16 bits.
  constexpr std::size_t kNumbers = 1 << 16;
  if (std::size_t{frame.leader.width} * frame.trailer.height < kNumbers)
    return Decode<std::uint16_t>(frame, pixel, one_by_one, range);
  std::vector<float> table(kNumbers);
  for (std::size_t number = 0; number < kNumbers; ++number) table[number] = DepthOf(static_cast<double>(number), scale);
  const auto by_table = [&](const std::vector<std::uint16_t>& numbers, std::vector<float>& depths) {
    LookUp(numbers.data(), numbers.size(), table.data(), depths.data());
  };
  return Decode<std::uint16_t>(frame, pixel, by_table, range);
}

}  // namespace geond::drivers::u3v
