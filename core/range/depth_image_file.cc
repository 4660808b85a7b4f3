// SPDX-License-Identifier: Apache-2.0
#include "core/range/depth_image_file.h"

#include <png.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <csetjmp>
#include <cstring>
#include <limits>

#include "core/base/error.h"

namespace geond {
namespace {

constexpr double kLargestCode = 65535.0;

struct Bytes {
  std::span<const std::uint8_t> data;
  std::size_t position = 0;
};

// libpng's way to say what went wrong: the text, and a long jump to whoever called. Only plain data may live across it.
struct PngFailure {
  std::jmp_buf jump;
  char message[128] = {};
};

[[noreturn]] void OnPngError(png_structp png, png_const_charp message) {
  auto* failure = static_cast<PngFailure*>(png_get_error_ptr(png));
  std::strncpy(failure->message, message, sizeof(failure->message) - 1);
  std::longjmp(failure->jump, 1);
}

void OnPngWarning(png_structp, png_const_charp) {}

void ReadBytes(png_structp png, png_bytep to, std::size_t n) {
  auto* bytes = static_cast<Bytes*>(png_get_io_ptr(png));
  if (n > bytes->data.size() - bytes->position) png_error(png, "the file ends too early");
  std::memcpy(to, bytes->data.data() + bytes->position, n);
  bytes->position += n;
}

void AppendBytes(png_structp png, png_bytep from, std::size_t n) {
  auto* bytes = static_cast<std::vector<std::uint8_t>*>(png_get_io_ptr(png));
  bytes->insert(bytes->end(), from, from + n);
}

void FlushNothing(png_structp) {}

// Reads up to the header, or (pixels given) the whole picture. False with failure.message set if that does not work.
bool ReadPng(Bytes& bytes, PngFailure& failure, int columns, int rows, std::uint16_t* pixels) {
  png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &failure, OnPngError, OnPngWarning);
  png_infop info = png != nullptr ? png_create_info_struct(png) : nullptr;
  if (info == nullptr || setjmp(failure.jump) != 0) {
    png_destroy_read_struct(&png, &info, nullptr);
    return false;
  }
  png_set_read_fn(png, &bytes, ReadBytes);
  png_set_user_limits(png, columns, rows);
  png_set_chunk_malloc_max(png, 1 << 20);
  png_read_info(png, info);
  if (png_get_color_type(png, info) != PNG_COLOR_TYPE_GRAY || png_get_bit_depth(png, info) != 16) {
    png_error(png, "the picture is not grey with 16 bits");
  }
  if (png_get_image_width(png, info) != static_cast<png_uint_32>(columns) ||
      png_get_image_height(png, info) != static_cast<png_uint_32>(rows)) {
    png_error(png, "the picture has another size than the sensor");
  }
  if (pixels != nullptr) {
    if (std::endian::native == std::endian::little) png_set_swap(png);
    const int passes = png_set_interlace_handling(png);
    for (int pass = 0; pass < passes; ++pass) {
      for (int row = 0; row < rows; ++row) {
        png_read_row(png, reinterpret_cast<png_bytep>(pixels + static_cast<std::size_t>(row) * columns), nullptr);
      }
    }
    png_read_end(png, nullptr);
  }
  png_destroy_read_struct(&png, &info, nullptr);
  return true;
}

bool WritePng(std::vector<std::uint8_t>& bytes, PngFailure& failure, int columns, int rows,
              const std::uint16_t* pixels) {
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, &failure, OnPngError, OnPngWarning);
  png_infop info = png != nullptr ? png_create_info_struct(png) : nullptr;
  if (info == nullptr || setjmp(failure.jump) != 0) {
    png_destroy_write_struct(&png, &info);
    return false;
  }
  png_set_write_fn(png, &bytes, AppendBytes, FlushNothing);
  png_set_IHDR(png, info, columns, rows, 16, PNG_COLOR_TYPE_GRAY, PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
               PNG_FILTER_TYPE_DEFAULT);
  png_write_info(png, info);
  if (std::endian::native == std::endian::little) png_set_swap(png);
  for (int row = 0; row < rows; ++row) {
    png_write_row(png, reinterpret_cast<png_const_bytep>(pixels + static_cast<std::size_t>(row) * columns));
  }
  png_write_end(png, nullptr);
  png_destroy_write_struct(&png, &info);
  return true;
}

}  // namespace

DepthCode FinestDepthCode(const RangeImage& image) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (float z : image.depth) {
    if (!std::isfinite(z)) continue;
    low = std::min<double>(low, z);
    high = std::max<double>(high, z);
  }
  if (!(low <= high)) return {1e-6, 0.0};
  // A little wider than the depths, so that rounding cannot leave the range; never finer than the floats themselves.
  const double scale = std::max((high - low) / (kLargestCode - 2.0), 1e-9);
  return {scale, low - 1.25 * scale};
}

std::vector<std::uint8_t> EncodeDepthPng(const RangeImage& image, const DepthCode& code) {
  std::vector<std::uint16_t> pixels(image.depth.size(), 0);
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    if (!std::isfinite(image.depth[i])) continue;
    const double k = std::round((image.depth[i] - code.offset) / code.scale);
    pixels[i] = static_cast<std::uint16_t>(std::clamp(k, 1.0, kLargestCode));
  }
  std::vector<std::uint8_t> bytes;
  PngFailure failure;
  if (!WritePng(bytes, failure, image.columns, image.rows, pixels.data())) {
    throw FileError("range image", "write PNG", failure.message);
  }
  return bytes;
}

RangeImage DecodeDepthPng(std::span<const std::uint8_t> bytes, int columns, int rows, const DepthCode& code,
                          const std::string& name) {
  const auto read = [&](std::uint16_t* pixels) {
    Bytes source{bytes};
    PngFailure failure;
    if (!ReadPng(source, failure, columns, rows, pixels)) {
      throw FileError(name, "read PNG",
                      std::string(failure.message) + " (near byte " + std::to_string(source.position) + ")",
                      "A range image is a grey 16-bit PNG of " + std::to_string(columns) + " x " +
                          std::to_string(rows) + " pixels");
    }
  };
  read(nullptr);
  std::vector<std::uint16_t> pixels(static_cast<std::size_t>(columns) * rows);
  read(pixels.data());

  RangeImage image{columns, rows, std::vector<float>(pixels.size(), std::numeric_limits<float>::quiet_NaN())};
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    if (pixels[i] != 0) image.depth[i] = static_cast<float>(code.offset + pixels[i] * code.scale);
  }
  return image;
}

std::vector<std::uint8_t> EncodeDepthFloats(const RangeImage& image) {
  std::vector<std::uint8_t> bytes;
  bytes.reserve(4 * image.depth.size());
  for (float z : image.depth) {
    // One NaN for all, whatever its bits were.
    const auto bits = std::isfinite(z) ? std::bit_cast<std::uint32_t>(z) : 0x7fc00000u;
    for (int shift = 0; shift < 32; shift += 8) bytes.push_back(static_cast<std::uint8_t>(bits >> shift));
  }
  return bytes;
}

RangeImage DecodeDepthFloats(std::span<const std::uint8_t> bytes, int columns, int rows, const std::string& name) {
  const std::size_t n = static_cast<std::size_t>(columns) * rows;
  if (bytes.size() != 4 * n) {
    throw FileError(name, "read depth",
                    std::to_string(bytes.size()) + " bytes where " + std::to_string(columns) + " x " +
                        std::to_string(rows) + " floats take " + std::to_string(4 * n));
  }
  RangeImage image{columns, rows, std::vector<float>(n)};
  for (std::size_t i = 0; i < n; ++i) {
    std::uint32_t bits = 0;
    for (int k = 3; k >= 0; --k) bits = bits << 8 | bytes[4 * i + k];
    image.depth[i] = std::bit_cast<float>(bits);
    if (std::isinf(image.depth[i]))
      throw FileError(name, "read depth", "infinite depth at byte " + std::to_string(4 * i));
  }
  return image;
}

}  // namespace geond
