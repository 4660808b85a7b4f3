// SPDX-License-Identifier: Apache-2.0
#include "calib/grid_file.h"

#include <array>
#include <bit>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <optional>
#include <string>
#include <string_view>

#include <lzma.h>

#include "core/base/printed.h"
#include "core/base/error.h"

namespace geond::calib {
namespace {

constexpr std::size_t kMaxUnpacked = std::size_t{1} << 30;  // bytes
constexpr std::size_t kMaxCells = 100'000'000;

[[noreturn]] void Fail(const std::filesystem::path& path, const std::string& cause, const std::string& remedy = {}) {
  throw FileError(path.string(), "read range grid", cause, remedy);
}

std::string ReadBytes(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) Fail(path, "the file cannot be opened", "Check name and permissions");
  return {std::istreambuf_iterator<char>(file), {}};
}

std::string Unpack(const std::filesystem::path& path, const std::string& packed) {
  lzma_stream stream = LZMA_STREAM_INIT;
  if (lzma_stream_decoder(&stream, std::uint64_t{256} << 20, 0) != LZMA_OK) Fail(path, "xz cannot start");
  std::string text;
  std::vector<std::uint8_t> buffer(1 << 16);
  stream.next_in = reinterpret_cast<const std::uint8_t*>(packed.data());
  stream.avail_in = packed.size();
  lzma_ret state = LZMA_OK;
  while (state == LZMA_OK && text.size() <= kMaxUnpacked) {
    stream.next_out = buffer.data();
    stream.avail_out = buffer.size();
    state = lzma_code(&stream, LZMA_FINISH);
    text.append(reinterpret_cast<const char*>(buffer.data()), buffer.size() - stream.avail_out);
  }
  const auto read = stream.total_in;
  lzma_end(&stream);
  if (state != LZMA_STREAM_END) {
    Fail(path, Printed("not a whole xz file (stopped at byte %llu)", static_cast<unsigned long long>(read)),
         "Fetch it again, or unpack it with xz -dk");
  }
  return text;
}

enum class Format { kAscii, kLittle, kBig };

struct Header {
  Format format = Format::kAscii;
  int columns = 0, rows = 0;
  std::size_t vertices = 0, cells = 0;
  std::vector<std::string> types, names;  // of the vertex
  std::string count_type, index_type;     // of the grid's list
};

std::size_t SizeOf(std::string_view type) {
  if (type == "char" || type == "uchar" || type == "int8" || type == "uint8") return 1;
  if (type == "short" || type == "ushort" || type == "int16" || type == "uint16") return 2;
  if (type == "int" || type == "uint" || type == "float" || type == "int32" || type == "uint32" || type == "float32") {
    return 4;
  }
  return type == "double" || type == "float64" ? 8 : 0;
}

// Takes numbers off the body of a PLY file, ascii or binary.
class Body {
 public:
  Body(const std::filesystem::path& path, std::string_view bytes, std::size_t at, Format format)
      : path_(path), bytes_(bytes), at_(at), format_(format) {}

  double Next(const std::string& type) { return format_ == Format::kAscii ? NextWord() : NextBinary(type); }

 private:
  double NextWord() {
    while (at_ < bytes_.size() && std::isspace(static_cast<unsigned char>(bytes_[at_]))) ++at_;
    double value = 0.0;
    const char* begin = bytes_.data() + at_;
    const auto [end, error] = std::from_chars(begin, bytes_.data() + bytes_.size(), value);
    if (error != std::errc()) Bad(at_ >= bytes_.size() ? "the file ends too early" : "not a number");
    at_ += static_cast<std::size_t>(end - begin);
    return value;
  }

  double NextBinary(const std::string& type) {
    const std::size_t size = SizeOf(type);
    if (bytes_.size() - at_ < size) Bad("the file ends too early");
    std::uint8_t raw[8] = {};
    for (std::size_t i = 0; i < size; ++i) {
      raw[format_ == Format::kBig ? size - 1 - i : i] = static_cast<std::uint8_t>(bytes_[at_ + i]);
    }
    at_ += size;
    const auto as = [&]<typename T>(T value) {
      std::memcpy(&value, raw, sizeof value);
      return static_cast<double>(value);
    };
    static_assert(std::endian::native == std::endian::little);
    if (type == "float" || type == "float32") return as(float{});
    if (type == "double" || type == "float64") return as(double{});
    if (type == "char" || type == "int8") return as(std::int8_t{});
    if (type == "uchar" || type == "uint8") return as(std::uint8_t{});
    if (type == "short" || type == "int16") return as(std::int16_t{});
    if (type == "ushort" || type == "uint16") return as(std::uint16_t{});
    return type[0] == 'u' ? as(std::uint32_t{}) : as(std::int32_t{});
  }

  [[noreturn]] void Bad(const char* cause) const { Fail(path_, Printed("%s at byte %zu", cause, at_)); }

  const std::filesystem::path& path_;
  std::string_view bytes_;
  std::size_t at_;
  Format format_;
};

std::vector<std::string> Words(std::string_view line) {
  std::vector<std::string> words;
  for (std::size_t at = 0; at < line.size();) {
    while (at < line.size() && std::isspace(static_cast<unsigned char>(line[at]))) ++at;
    const std::size_t begin = at;
    while (at < line.size() && !std::isspace(static_cast<unsigned char>(line[at]))) ++at;
    if (at > begin) words.emplace_back(line.substr(begin, at - begin));
  }
  return words;
}

std::size_t Count(const std::filesystem::path& path, const std::string& word, std::size_t line, std::size_t most) {
  std::size_t value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size() || value > most) {
    Fail(path, Printed("'%s' is no possible count in line %zu", word.substr(0, 40).c_str(), line));
  }
  return value;
}

// Returns the byte where the body begins.
std::size_t ReadHeader(const std::filesystem::path& path, std::string_view bytes, Header& header) {
  std::string element;
  std::size_t at = 0;
  for (std::size_t number = 1;; ++number) {
    const std::size_t end = bytes.find('\n', at);
    if (end == std::string_view::npos) Fail(path, Printed("the header has no end (line %zu)", number));
    const auto words = Words(bytes.substr(at, end - at));
    at = end + 1;
    if (number == 1 && (words.empty() || words[0] != "ply")) Fail(path, "not a PLY file (line 1)");
    if (words.empty()) continue;
    const std::string& key = words[0];
    if (key == "end_header") return at;
    if (key == "format" && words.size() >= 2) {
      header.format = words[1] == "ascii"                  ? Format::kAscii
                      : words[1] == "binary_little_endian" ? Format::kLittle
                                                           : Format::kBig;
    } else if (key == "obj_info" && words.size() >= 3 && words[1] == "num_cols") {
      header.columns = static_cast<int>(Count(path, words[2], number, 100'000));
    } else if (key == "obj_info" && words.size() >= 3 && words[1] == "num_rows") {
      header.rows = static_cast<int>(Count(path, words[2], number, 100'000));
    } else if (key == "element" && words.size() >= 3) {
      element = words[1];
      // A number takes a byte at least: no header can promise more than the file holds.
      const std::size_t count = Count(path, words[2], number, std::min(bytes.size(), kMaxCells));
      if (element == "vertex") header.vertices = count;
      if (element == "range_grid") header.cells = count;
      if (element != "vertex" && element != "range_grid" && count > 0) {
        Fail(path, Printed("element '%s' in line %zu: only vertex and range_grid are known here",
                           element.substr(0, 40).c_str(), number));
      }
    } else if (key == "property" && element == "vertex" && words.size() >= 3) {
      if (SizeOf(words[1]) == 0) Fail(path, Printed("unknown type in line %zu", number));
      header.types.push_back(words[1]);
      header.names.push_back(words[2]);
    } else if (key == "property" && element == "range_grid") {
      if (words.size() < 5 || words[1] != "list" || SizeOf(words[2]) == 0 || SizeOf(words[3]) == 0) {
        Fail(path, Printed("range_grid needs one list of vertex indices (line %zu)", number));
      }
      header.count_type = words[2];
      header.index_type = words[3];
    }
  }
}

}  // namespace

PointGrid ReadGridFile(const std::filesystem::path& path) {
  std::string bytes = ReadBytes(path);
  if (path.extension() == ".xz") bytes = Unpack(path, bytes);
  Header header;
  const std::size_t begin = ReadHeader(path, bytes, header);
  if (header.count_type.empty() || header.columns <= 0 || header.rows <= 0) {
    Fail(path, "no range grid (element range_grid with obj_info num_cols and num_rows)",
         "A mesh or a cloud can be described by itself");
  }
  if (header.cells != static_cast<std::size_t>(header.columns) * header.rows) {
    Fail(path, Printed("%zu grid cells for %d columns and %d rows", header.cells, header.columns, header.rows));
  }
  std::array<int, 3> xyz = {-1, -1, -1};
  for (std::size_t i = 0; i < header.names.size(); ++i) {
    if (header.names[i].size() == 1 && header.names[i][0] >= 'x' && header.names[i][0] <= 'z') {
      xyz[header.names[i][0] - 'x'] = static_cast<int>(i);
    }
  }
  if (xyz[0] < 0 || xyz[1] < 0 || xyz[2] < 0) Fail(path, "the vertices lack x, y or z");

  Body body(path, bytes, begin, header.format);
  PointGrid grid;
  grid.columns = header.columns;
  grid.rows = header.rows;
  std::vector<double> values(header.types.size());
  for (std::size_t k = 0; k < header.vertices; ++k) {
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = body.Next(header.types[i]);
    grid.points.emplace_back(values[xyz[0]], values[xyz[1]], values[xyz[2]]);
    if (!grid.points.back().allFinite()) Fail(path, Printed("vertex %zu is not finite", k));
  }
  for (std::size_t k = 0; k < header.cells; ++k) {
    const double count = body.Next(header.count_type);
    if (count != 0.0 && count != 1.0) Fail(path, Printed("grid cell %zu has %g points, not 0 or 1", k, count));
    const double index = count == 1.0 ? body.Next(header.index_type) : -1.0;
    if (count == 1.0 && !(index >= 0 && index < static_cast<double>(header.vertices))) {
      Fail(path, Printed("grid cell %zu points to vertex %g of %zu", k, index, header.vertices));
    }
    grid.cells.push_back(static_cast<int>(index));
  }
  return grid;
}

}  // namespace geond::calib
