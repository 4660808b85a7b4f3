// SPDX-License-Identifier: Apache-2.0
#include "drivers/u3v_depth.h"

#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

namespace geond::drivers::u3v {
namespace {

static_assert(std::endian::native == std::endian::little, "numbers are copied as they are on the wire");

float DepthOf(double value, const DepthScale& scale) {
  const double depth = (value * scale.scale + scale.offset) * scale.metres;
  const bool none = (scale.invalid && value == *scale.invalid) || !std::isfinite(depth) || depth <= 0.0;
  return none ? std::numeric_limits<float>::quiet_NaN() : static_cast<float>(depth);
}

// Every pixel's number, `pixel` bytes apart from `first` of its row on.
template <typename Number, typename ToDepth>
void DecodeRows(const Frame& frame, std::size_t first, std::size_t pixel, const ToDepth& to_depth, RangeImage& image) {
  const std::size_t columns = frame.leader.width, row_size = columns * pixel + frame.leader.padding_x;
  for (std::size_t row = 0; row < frame.trailer.height; ++row) {
    const std::uint8_t* bytes = frame.payload.data() + row * row_size + first;
    float* depths = image.depth.data() + row * columns;
    for (std::size_t column = 0; column < columns; ++column) {
      Number number;
      std::memcpy(&number, bytes + column * pixel, sizeof number);
      depths[column] = to_depth(number);
    }
  }
}

}  // namespace

RangeImage DecodeDepth(const Frame& frame, const DepthScale& scale) {
  const auto format = static_cast<PixelFormat>(frame.leader.pixel_format);
  const std::size_t pixel = BytesPerPixel(frame.leader.pixel_format);
  const bool is_float = format == PixelFormat::kCoord3dC32f || format == PixelFormat::kCoord3dAbc32f;
  RangeImage image;
  image.columns = static_cast<int>(frame.leader.width);
  image.rows = static_cast<int>(frame.trailer.height);
  image.depth.resize(std::size_t{frame.leader.width} * frame.trailer.height);
  // Depth is the last of a pixel's numbers.
  if (is_float) {
    DecodeRows<float>(frame, pixel - 4, pixel, [&](float value) { return DepthOf(value, scale); }, image);
    return image;
  }
  // A large image has more pixels than there are numbers of 16 bits.
  constexpr std::size_t kNumbers = 1 << 16;
  if (image.depth.size() < kNumbers) {
    DecodeRows<std::uint16_t>(frame, pixel - 2, pixel, [&](std::uint16_t value) { return DepthOf(value, scale); }, image);
    return image;
  }
  std::vector<float> depths(kNumbers);
  for (std::size_t number = 0; number < kNumbers; ++number) depths[number] = DepthOf(static_cast<double>(number), scale);
  DecodeRows<std::uint16_t>(frame, pixel - 2, pixel, [&](std::uint16_t value) { return depths[value]; }, image);
  return image;
}

}  // namespace geond::drivers::u3v
