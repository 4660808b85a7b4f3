// SPDX-License-Identifier: Apache-2.0
#include "core/picture/image.h"

#include <png.h>

#include <fstream>
#include <stdexcept>
#include <string>

#include "core/base/error.h"

namespace geond {

Color Image::at(int column, int row) const {
  const std::size_t i = 3 * (static_cast<std::size_t>(row) * columns + column);
  return Color(rgb[i], rgb[i + 1], rgb[i + 2]) / 255.0f;
}

std::vector<std::uint8_t> EncodePng(const Image& image) {
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  png.width = static_cast<png_uint_32>(image.columns);
  png.height = static_cast<png_uint_32>(image.rows);
  png.format = PNG_FORMAT_RGB;
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(png);
  std::vector<std::uint8_t> bytes(size);
  if (png_image_write_to_memory(&png, bytes.data(), &size, 0, image.rgb.data(), 3 * image.columns, nullptr) == 0) {
    throw std::invalid_argument(std::string("the image cannot be a PNG: ") + png.message);
  }
  bytes.resize(size);
  return bytes;
}

void WritePng(const Image& image, const std::filesystem::path& path) {
  const std::vector<std::uint8_t> bytes = EncodePng(image);
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  file.close();
  if (!file)
    throw FileError(path.string(), "write PNG", "the file cannot be written",
                    "Check folder, permissions and free space");
}

}  // namespace geond
