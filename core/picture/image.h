// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "core/picture/color.h"

namespace geond {

// A picture: red, green, blue of each pixel, row by row from the upper left.
struct Image {
  int columns = 0;
  int rows = 0;
  std::vector<std::uint8_t> rgb;
  Color at(int column, int row) const;
};

// The bytes of an 8-bit RGB PNG. Throws std::invalid_argument if the image has no size.
std::vector<std::uint8_t> EncodePng(const Image& image);
// The same into a file. Throws FileError.
void WritePng(const Image& image, const std::filesystem::path& path);

}  // namespace geond
