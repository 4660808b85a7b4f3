// SPDX-License-Identifier: Apache-2.0
// PCD, the cloud format of the Point Cloud Library: a text header (fields, their size, type and count, the number of
// points), then the points as text, as bytes, or as bytes field by field packed by LZF.
#include <algorithm>
#include <bit>
#include <cmath>
#include <optional>

#include "core/base/error.h"
#include "core/geometry/file_formats.h"
#include "core/geometry/line_reader.h"

namespace geond {
namespace {

struct Field {
  std::string name;
  int size = 4;
  char type = 'F';
  std::int64_t count = 1;
  std::size_t offset = 0;  // of the first value: bytes within a point
};

struct Header {
  std::vector<Field> fields;
  std::int64_t width = -1, height = 1, points = -1;
  std::size_t point_bytes = 0;
  std::string data;
};

Header ReadHeader(LineReader& lines) {
  Header header;
  std::vector<Field>& fields = header.fields;
  const auto for_each_field = [&](const auto& set) {
    if (fields.empty()) lines.Fail("FIELDS must come first");
    for (Field& field : fields) set(field);
  };
  while (header.data.empty()) {
    if (!lines.Next("#")) lines.Fail("the header has no line DATA", "The file may have been cut off");
    const std::string_view key = lines.Word();
    if (key == "FIELDS" || key == "COLUMNS") {
      while (lines.MoreOnLine()) fields.push_back({std::string(lines.Word())});
      if (fields.empty() || fields.size() > 1000) lines.Fail("no fields, or too many");
    } else if (key == "SIZE") {
      for_each_field([&](Field& field) {
        const std::int64_t size = lines.Integer("the size of a field");
        if (size != 1 && size != 2 && size != 4 && size != 8) lines.Fail("a field must have 1, 2, 4 or 8 bytes");
        field.size = static_cast<int>(size);
      });
    } else if (key == "TYPE") {
      for_each_field([&](Field& field) {
        const std::string_view type = lines.Word();
        if (type != "F" && type != "U" && type != "I") lines.Fail("the type of a field must be F, U or I");
        field.type = type[0];
      });
    } else if (key == "COUNT") {
      for_each_field([&](Field& field) {
        field.count = lines.Integer("the count of a field");
        if (field.count < 1 || field.count > 100000) lines.Fail("the count of a field must lie between 1 and 100000");
      });
    } else if (key == "WIDTH" || key == "HEIGHT" || key == "POINTS") {
      const std::int64_t n = lines.Integer("a number of points");
      if (n < 0 || n > INT32_MAX) lines.Fail("the number of points must lie between 0 and 2^31");
      (key == "WIDTH" ? header.width : key == "HEIGHT" ? header.height : header.points) = n;
    } else if (key == "DATA") {
      header.data = lines.Word();
    } else if (key != "VERSION" && key != "VIEWPOINT") {
      lines.Fail("unknown keyword " + Quoted(key) + " in the header");
    }
  }
  if (header.points < 0 && header.width >= 0) header.points = header.width * header.height;
  if (header.points < 0) lines.Fail("the header says no number of points");
  if (header.width >= 0 && header.width * header.height != header.points)
    lines.Fail("POINTS is not WIDTH times HEIGHT");
  for (Field& field : fields) {
    if (field.type == 'F' && field.size < 4) lines.Fail("a field of type F must have 4 or 8 bytes");
    field.offset = header.point_bytes;
    header.point_bytes += static_cast<std::size_t>(field.size) * field.count;
  }
  return header;
}

// The six fields that are read: positions, then normals.
struct Columns {
  std::array<const Field*, 6> field{};
  bool normals() const { return field[3] != nullptr && field[4] != nullptr && field[5] != nullptr; }
};

Columns FindColumns(const Header& header, const LineReader& lines) {
  constexpr const char* kNames[] = {"x", "y", "z", "normal_x", "normal_y", "normal_z"};
  Columns columns;
  for (const Field& field : header.fields) {
    for (int k = 0; k < 6; ++k) {
      if (field.name == kNames[k] && columns.field[k] == nullptr) columns.field[k] = &field;
    }
  }
  for (int k = 0; k < 3; ++k) {
    if (columns.field[k] == nullptr) lines.Fail(std::string("the points have no field ") + kNames[k]);
  }
  return columns;
}

double ValueAt(std::string_view bytes, std::size_t at, const Field& field) {
  std::uint64_t bits = 0;
  for (int k = field.size - 1; k >= 0; --k) bits = bits << 8 | static_cast<unsigned char>(bytes[at + k]);
  if (field.type == 'F') {
    return field.size == 4 ? std::bit_cast<float>(static_cast<std::uint32_t>(bits)) : std::bit_cast<double>(bits);
  }
  if (field.type == 'U') return static_cast<double>(bits);
  const int shift = 64 - 8 * field.size;
  return static_cast<double>(static_cast<std::int64_t>(bits << shift) >> shift);
}

// Unpacks LZF (M. Lehmann's format): a byte below 32 announces that many and one bytes as they are, any other a copy
// from what was unpacked before. None if the packed bytes make no sense or do not give `n` bytes.
std::optional<std::string> UnpackLzf(std::string_view packed, std::size_t n) {
  std::string out;
  out.reserve(n);
  for (std::size_t i = 0; i < packed.size();) {
    const auto control = static_cast<unsigned char>(packed[i++]);
    if (control < 32) {
      const std::size_t length = control + 1u;
      if (length > packed.size() - i || length > n - out.size()) return std::nullopt;
      out.append(packed.substr(i, length));
      i += length;
      continue;
    }
    std::size_t length = control >> 5;
    if (length == 7) {
      if (i >= packed.size()) return std::nullopt;
      length += static_cast<unsigned char>(packed[i++]);
    }
    length += 2;
    if (i >= packed.size()) return std::nullopt;
    const std::size_t back = ((control & 31u) << 8 | static_cast<unsigned char>(packed[i++])) + 1u;
    if (back > out.size() || length > n - out.size()) return std::nullopt;
    for (std::size_t k = 0; k < length; ++k) out += out[out.size() - back];
  }
  if (out.size() != n) return std::nullopt;
  return out;
}

class PointSink {
 public:
  explicit PointSink(bool normals) : normals_(normals) {}
  void Add(const std::array<double, 6>& v) {
    const Eigen::Vector3d p(v[0], v[1], v[2]);
    if (!p.allFinite()) {
      ++n_dropped_;
      return;
    }
    file_.cloud.points.push_back(p);
    if (normals_) file_.cloud.normals.push_back({v[3], v[4], v[5]});
  }
  GeometryFile Take(const std::string& name) {
    if (n_dropped_ > 0)
      file_.notes.push_back(std::to_string(n_dropped_) + " points without coordinates (nan) were left out");
    return Assemble(std::move(file_), {}, name);
  }

 private:
  bool normals_;
  int n_dropped_ = 0;
  GeometryFile file_;
};

void ReadText(const Header& header, const Columns& columns, LineReader& lines, PointSink& sink) {
  for (std::int64_t i = 0; i < header.points; ++i) {
    if (!lines.Next()) {
      lines.Fail("the file ends after " + std::to_string(i) + " of " + std::to_string(header.points) + " points",
                 "It may have been cut off");
    }
    std::array<double, 6> point{};
    for (const Field& field : header.fields) {
      for (std::int64_t c = 0; c < field.count; ++c) {
        const double value = lines.Number("a field");
        for (int k = 0; k < 6; ++k) {
          if (c == 0 && columns.field[k] == &field) point[k] = value;
        }
      }
    }
    if (lines.MoreOnLine()) lines.Fail("the line has more values than the header says");
    sink.Add(point);
  }
  if (lines.Next()) lines.Fail("there is more in the file than the header says");
}

// `stride_of` and `start_of` say where the first value of a field of point i lies: start + i * stride.
template <typename Start, typename Stride>
void ReadBytes(const Header& header, const Columns& columns, std::string_view bytes, const Start& start_of,
               const Stride& stride_of, PointSink& sink) {
  for (std::size_t i = 0; i < static_cast<std::size_t>(header.points); ++i) {
    std::array<double, 6> point{};
    for (int k = 0; k < (columns.normals() ? 6 : 3); ++k) {
      const Field& field = *columns.field[k];
      point[k] = ValueAt(bytes, start_of(field) + i * stride_of(field), field);
    }
    sink.Add(point);
  }
}

}  // namespace

bool LooksLikePcd(std::string_view bytes) {
  return bytes.substr(0, 6) == "# .PCD" || bytes.substr(0, 8) == "VERSION " || bytes.substr(0, 7) == "FIELDS ";
}

GeometryFile ReadPcd(const FileContent& content) {
  LineReader lines(content.bytes, content.name);
  const Header header = ReadHeader(lines);
  const Columns columns = FindColumns(header, lines);
  PointSink sink(columns.normals());
  const std::size_t begin = lines.position(), n = static_cast<std::size_t>(header.points);
  const std::string_view body = content.bytes.substr(begin);
  const std::size_t wanted = n * header.point_bytes;
  const auto fail = [&](std::size_t at, const std::string& cause) {
    throw FileError(content.name, "read byte " + std::to_string(at), cause, "It may have been cut off");
  };
  if (header.data == "ascii") {
    ReadText(header, columns, lines, sink);
  } else if (header.data == "binary") {
    if (body.size() < wanted ||
        body.find_first_not_of(std::string_view("\0\r\n ", 4), wanted) != std::string_view::npos) {
      fail(begin, std::to_string(n) + " points take " + std::to_string(wanted) + " bytes, but " +
                      std::to_string(body.size()) + " follow the header");
    }
    ReadBytes(
        header, columns, body, [](const Field& field) { return field.offset; },
        [&](const Field&) { return header.point_bytes; }, sink);
  } else if (header.data == "binary_compressed") {
    if (body.size() < 8) fail(begin, "the file ends before its points");
    const std::size_t packed = Unsigned32At(body, 0), unpacked = Unsigned32At(body, 4);
    if (packed > body.size() - 8) {
      fail(begin, "the points take " + std::to_string(packed) + " packed bytes, but " +
                      std::to_string(body.size() - 8) + " follow");
    }
    // Three packed bytes give 264 at best.
    if (unpacked != wanted || unpacked > 88 * packed) {
      fail(begin + 4, std::to_string(n) + " points do not take " + std::to_string(unpacked) + " unpacked bytes");
    }
    const std::optional<std::string> bytes = UnpackLzf(body.substr(8, packed), unpacked);
    if (!bytes) fail(begin + 8, "the packed points are damaged");
    ReadBytes(
        header, columns, *bytes, [&](const Field& field) { return field.offset * n; },
        [](const Field& field) { return static_cast<std::size_t>(field.size) * field.count; }, sink);
  } else {
    lines.Fail("unknown kind of data " + Quoted(header.data));
  }
  return sink.Take(content.name);
}

std::string PcdText(const PointCloud& cloud) {
  const bool normals = cloud.has_normals();
  const std::string n = std::to_string(cloud.size());
  std::string text = "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\n";
  text += normals ? "FIELDS x y z normal_x normal_y normal_z\nSIZE 4 4 4 4 4 4\nTYPE F F F F F F\nCOUNT 1 1 1 1 1 1\n"
                  : "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\n";
  text += "WIDTH " + n + "\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " + n + "\nDATA binary\n";
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    for (double c : cloud.points[i]) AppendLittleEndian(text, static_cast<float>(c));
    if (!normals) continue;
    for (double c : cloud.normals[i]) AppendLittleEndian(text, static_cast<float>(c));
  }
  return text;
}

}  // namespace geond
