// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/range/range_image.h"

namespace geond {

// Depth as 16-bit whole numbers: 0 is no return, k >= 1 is offset + k * scale (m).
struct DepthCode {
  double scale = 0.0;
  double offset = 0.0;
};

// The finest code that holds every depth of the image: its error is at most scale / 2.
DepthCode FinestDepthCode(const RangeImage& image);

// A grey 16-bit PNG of the quantised image, and back. Decoding throws FileError (thing = `name`) if the bytes are no
// such PNG or its size is not columns x rows; that is asked before anything is allocated.
std::vector<std::uint8_t> EncodeDepthPng(const RangeImage& image, const DepthCode& code);
RangeImage DecodeDepthPng(std::span<const std::uint8_t> bytes, int columns, int rows, const DepthCode& code,
                          const std::string& name);

// Depth as raw 32-bit little-endian floats, row by row, NaN where there is no return; to the bit. Decoding throws
// FileError if the number of bytes is not 4 * columns * rows, or a depth is infinite.
std::vector<std::uint8_t> EncodeDepthFloats(const RangeImage& image);
RangeImage DecodeDepthFloats(std::span<const std::uint8_t> bytes, int columns, int rows, const std::string& name);

}  // namespace geond
