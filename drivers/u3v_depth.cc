// SPDX-License-Identifier: Apache-2.0
#include "drivers/u3v_depth.h"

#include <bit>
#include <cmath>
#include <limits>

#include "drivers/little_endian.h"

namespace geond::drivers::u3v {

RangeImage DecodeDepth(const Frame& frame, const DepthScale& scale) {
  const auto format = static_cast<PixelFormat>(frame.leader.pixel_format);
  const std::size_t pixel = BytesPerPixel(frame.leader.pixel_format);
  const bool is_float = format == PixelFormat::kCoord3dC32f || format == PixelFormat::kCoord3dAbc32f;
  const std::size_t number = is_float ? 4 : 2;
  const std::size_t row_size = frame.leader.width * pixel + frame.leader.padding_x;
  RangeImage image;
  image.columns = static_cast<int>(frame.leader.width);
  image.rows = static_cast<int>(frame.trailer.height);
  image.depth.resize(std::size_t{frame.leader.width} * frame.trailer.height);
  const ByteView bytes = frame.payload;
  for (std::size_t row = 0; row < frame.trailer.height; ++row) {
    for (std::size_t column = 0; column < frame.leader.width; ++column) {
      // Depth is the last of a pixel's numbers.
      const std::size_t at = row * row_size + column * pixel + pixel - number;
      const double value = is_float ? std::bit_cast<float>(ReadLittleEndian<std::uint32_t>(bytes, at))
                                    : ReadLittleEndian<std::uint16_t>(bytes, at);
      const double depth = (value * scale.scale + scale.offset) * scale.metres;
      const bool none = (scale.invalid && value == *scale.invalid) || !std::isfinite(depth) || depth <= 0.0;
      image.depth[row * frame.leader.width + column] =
          none ? std::numeric_limits<float>::quiet_NaN() : static_cast<float>(depth);
    }
  }
  return image;
}

}  // namespace geond::drivers::u3v
