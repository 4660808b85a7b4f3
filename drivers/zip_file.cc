// SPDX-License-Identifier: Apache-2.0
#include "drivers/zip_file.h"

#include <zlib.h>

#include <optional>

#include "core/base/error.h"
#include "drivers/little_endian.h"

namespace geond::drivers {
namespace {

constexpr std::uint32_t kEndOfDirectory = 0x06054b50, kDirectoryEntry = 0x02014b50, kLocalHeader = 0x04034b50;
constexpr std::size_t kEndSize = 22, kEntrySize = 46, kLocalSize = 30;
constexpr std::size_t kLargest = 64 << 20;

[[noreturn]] void Broken(const std::string& cause) { throw DeviceError("camera", "unpack description", cause); }

}  // namespace

std::string UnzipFirstFile(std::span<const std::uint8_t> archive) {
  std::optional<std::size_t> end;
  for (std::size_t at = archive.size() < kEndSize ? 0 : archive.size() - kEndSize + 1; at-- > 0 && !end;) {
    if (ReadLittleEndian<std::uint32_t>(archive, at) == kEndOfDirectory) end = at;
  }
  if (!end) Broken("it is no zip archive");
  const std::size_t entry = ReadLittleEndian<std::uint32_t>(archive, *end + 16);
  if (entry + kEntrySize > archive.size() || ReadLittleEndian<std::uint32_t>(archive, entry) != kDirectoryEntry) {
    Broken("its directory is broken");
  }
  const auto method = ReadLittleEndian<std::uint16_t>(archive, entry + 10);
  const auto checksum = ReadLittleEndian<std::uint32_t>(archive, entry + 16);
  const std::size_t packed = ReadLittleEndian<std::uint32_t>(archive, entry + 20);
  const std::size_t size = ReadLittleEndian<std::uint32_t>(archive, entry + 24);
  const std::size_t local = ReadLittleEndian<std::uint32_t>(archive, entry + 42);
  if (local + kLocalSize > archive.size() || ReadLittleEndian<std::uint32_t>(archive, local) != kLocalHeader) {
    Broken("its file's header is broken");
  }
  const std::size_t begin = local + kLocalSize + ReadLittleEndian<std::uint16_t>(archive, local + 26) +
                            ReadLittleEndian<std::uint16_t>(archive, local + 28);
  if (begin + packed > archive.size() || size > kLargest) Broken("its file is cut or too large");
  std::string text(size, '\0');
  if (method == 0 && packed == size) {
    text.assign(archive.begin() + static_cast<std::ptrdiff_t>(begin),
                archive.begin() + static_cast<std::ptrdiff_t>(begin + size));
  } else if (method == 8) {
    z_stream stream{};
    if (inflateInit2(&stream, -MAX_WBITS) != Z_OK) Broken("no memory");
    stream.next_in = const_cast<Bytef*>(archive.data() + begin);
    stream.avail_in = static_cast<uInt>(packed);
    stream.next_out = reinterpret_cast<Bytef*>(text.data());
    stream.avail_out = static_cast<uInt>(size);
    const int result = inflate(&stream, Z_FINISH);
    inflateEnd(&stream);
    if (result != Z_STREAM_END || stream.total_out != size) Broken("its file does not unpack");
  } else {
    Broken("its packing, method " + std::to_string(method) + ", is not understood");
  }
  if (crc32(0, reinterpret_cast<const Bytef*>(text.data()), static_cast<uInt>(size)) != checksum) {
    Broken("its file's checksum is wrong");
  }
  return text;
}

}  // namespace geond::drivers
