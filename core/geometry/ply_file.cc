// SPDX-License-Identifier: Apache-2.0
// PLY, the polygon file format (G. Turk, 1994): a text header that declares elements and their properties, then the
// elements as text or in either byte order.
#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <optional>

#include "core/base/error.h"
#include "core/geometry/file_formats.h"
#include "core/geometry/line_reader.h"

namespace geond {
namespace {

enum class Type { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat32, kFloat64 };

struct TypeName {
  const char* name;
  const char* sized_name;
  Type type;
  int bytes;
};
constexpr TypeName kTypes[] = {{"char", "int8", Type::kInt8, 1},        {"uchar", "uint8", Type::kUint8, 1},
                               {"short", "int16", Type::kInt16, 2},     {"ushort", "uint16", Type::kUint16, 2},
                               {"int", "int32", Type::kInt32, 4},       {"uint", "uint32", Type::kUint32, 4},
                               {"float", "float32", Type::kFloat32, 4}, {"double", "float64", Type::kFloat64, 8}};

int Size(Type type) { return kTypes[static_cast<int>(type)].bytes; }

struct Property {
  std::string name;
  Type type = Type::kFloat32;
  std::optional<Type> count_type;  // of a list
};

struct Element {
  std::string name;
  std::int64_t count = 0;
  std::vector<Property> properties;

  int Find(std::string_view property, bool list) const {
    for (std::size_t k = 0; k < properties.size(); ++k) {
      if (properties[k].name == property && properties[k].count_type.has_value() == list) return static_cast<int>(k);
    }
    return -1;
  }
  // The fewest bytes one such element can take.
  std::int64_t LeastBytes(bool ascii) const {
    std::int64_t bytes = 0;
    for (const Property& property : properties) bytes += ascii ? 2 : Size(property.count_type.value_or(property.type));
    return bytes;
  }
};

enum class Format { kAscii, kLittleEndian, kBigEndian };

struct Header {
  Format format = Format::kAscii;
  std::vector<Element> elements;
};

Type ParseType(std::string_view word, const LineReader& lines) {
  for (const TypeName& type : kTypes) {
    if (word == type.name || word == type.sized_name) return type.type;
  }
  lines.Fail("unknown type " + Quoted(word) + " of a property");
}

Format ParseFormat(std::string_view word, const LineReader& lines) {
  if (word == "ascii") return Format::kAscii;
  if (word == "binary_little_endian") return Format::kLittleEndian;
  if (word == "binary_big_endian") return Format::kBigEndian;
  lines.Fail("unknown format " + Quoted(word));
}

Element ParseElement(LineReader& lines) {
  Element element;
  element.name = lines.Word();
  element.count = lines.Integer("the number of elements");
  if (element.count < 0) lines.Fail("a negative number of elements");
  if (element.name == "tristrips") {
    lines.Fail("triangle strips are not read", "Save the mesh with faces (vertex_indices) instead");
  }
  return element;
}

Property ParseProperty(LineReader& lines) {
  Property property;
  std::string_view word = lines.Word();
  if (word == "list") {
    property.count_type = ParseType(lines.Word(), lines);
    if (*property.count_type >= Type::kFloat32) lines.Fail("the length of a list must be a whole number");
    word = lines.Word();
  }
  property.type = ParseType(word, lines);
  property.name = lines.Word();
  if (property.name.empty()) lines.Fail("a property without a name");
  return property;
}

// Leaves the reader behind the header's last line.
Header ReadHeader(LineReader& lines) {
  Header header;
  bool has_format = false;
  lines.Next();  // "ply"
  for (;;) {
    if (!lines.Next()) lines.Fail("the header has no end_header", "The file may have been cut off");
    const std::string_view key = lines.Word();
    if (key == "end_header") break;
    if (key == "comment" || key == "obj_info") continue;
    if (key == "format") {
      header.format = ParseFormat(lines.Word(), lines);
      has_format = true;
    } else if (key == "element") {
      header.elements.push_back(ParseElement(lines));
    } else if (key == "property") {
      if (header.elements.empty()) lines.Fail("a property before any element");
      header.elements.back().properties.push_back(ParseProperty(lines));
    } else {
      lines.Fail("unknown keyword " + Quoted(key) + " in the header");
    }
  }
  if (!has_format) lines.Fail("the header says no format");
  return header;
}

// One element after the other from text, an element a line.
class AsciiSource {
 public:
  explicit AsciiSource(LineReader& lines) : lines_(lines) {}

  void Begin(const Element& element) {
    if (!lines_.Next()) Fail("the file ends before its last " + Quoted(element.name), "It may have been cut off");
  }
  double Value(Type, const Property& property) { return lines_.Number(property.name.c_str()); }
  void ExpectRoom(double count, Type, const Property& property) {
    if (count > static_cast<double>(lines_.rest().size()))
      Fail("the line is too short for the list " + Quoted(property.name));
  }
  void End() {
    if (lines_.MoreOnLine()) Fail("the line has more values than the header says");
  }
  std::size_t remaining() const { return lines_.remaining(); }
  void ExpectEnd() {
    if (lines_.Next()) Fail("there is more in the file than the header says");
  }
  [[noreturn]] void Fail(const std::string& cause, const std::string& remedy = {}) const { lines_.Fail(cause, remedy); }

 private:
  LineReader& lines_;
};

class BinarySource {
 public:
  BinarySource(const FileContent& file, std::size_t begin, bool big_endian)
      : file_(file), position_(begin), big_endian_(big_endian) {}

  void Begin(const Element&) {}
  double Value(Type type, const Property& property) {
    const int size = Size(type);
    if (file_.bytes.size() - position_ < static_cast<std::size_t>(size)) {
      Fail("the file ends where " + Quoted(property.name) + " is wanted", "It may have been cut off");
    }
    std::uint64_t bits = 0;
    for (int k = 0; k < size; ++k) {
      const auto byte = static_cast<unsigned char>(file_.bytes[position_ + (big_endian_ ? k : size - 1 - k)]);
      bits = bits << 8 | byte;
    }
    position_ += size;
    switch (type) {
      case Type::kInt8:
        return static_cast<std::int8_t>(bits);
      case Type::kUint8:
        return static_cast<std::uint8_t>(bits);
      case Type::kInt16:
        return static_cast<std::int16_t>(bits);
      case Type::kUint16:
        return static_cast<std::uint16_t>(bits);
      case Type::kInt32:
        return static_cast<std::int32_t>(bits);
      case Type::kUint32:
        return static_cast<std::uint32_t>(bits);
      case Type::kFloat32:
        return std::bit_cast<float>(static_cast<std::uint32_t>(bits));
      case Type::kFloat64:
        return std::bit_cast<double>(bits);
    }
    return 0.0;
  }
  void ExpectRoom(double count, Type type, const Property& property) {
    if (count * Size(type) > static_cast<double>(remaining())) {
      Fail("the list " + Quoted(property.name) + " is longer than the file", "It may have been cut off");
    }
  }
  void End() {}
  std::size_t remaining() const { return file_.bytes.size() - position_; }
  void ExpectEnd() {
    const std::size_t more = file_.bytes.find_first_not_of(" \t\r\n", position_);
    if (more != std::string_view::npos) {
      Fail(std::to_string(remaining()) + " bytes more in the file than the header says");
    }
  }
  [[noreturn]] void Fail(const std::string& cause, const std::string& remedy = {}) const {
    throw FileError(file_.name, "read byte " + std::to_string(position_), cause, remedy);
  }

 private:
  const FileContent& file_;
  std::size_t position_;
  bool big_endian_;
};

// The elements, one kind after the other, into points and faces.
template <typename Source>
class PlyBody {
 public:
  PlyBody(const Header& header, Source& source) : source_(source) {
    const bool ascii = header.format == Format::kAscii;
    for (const Element& element : header.elements) {
      if (element.name != "vertex") continue;
      if (n_vertices_ > 0) source_.Fail("the element vertex is declared twice");
      n_vertices_ = element.count;
    }
    for (const Element& element : header.elements) {
      const double least = static_cast<double>(element.count) * static_cast<double>(element.LeastBytes(ascii));
      if (least > static_cast<double>(source_.remaining()) + 1.0) {
        source_.Fail("the header says " + std::to_string(element.count) + " elements " + Quoted(element.name) +
                         ", more than the rest of the file can hold",
                     "The file may have been cut off");
      }
      if (element.name == "vertex")
        ReadVertices(element);
      else if (element.name == "face")
        ReadFaces(element);
      else if (!element.properties.empty())
        Skip(element);
    }
    source_.ExpectEnd();
  }

  GeometryFile file;
  PolygonList polygons;

 private:
  void ReadVertices(const Element& element) {
    const int position[] = {element.Find("x", false), element.Find("y", false), element.Find("z", false)};
    const int normal[] = {element.Find("nx", false), element.Find("ny", false), element.Find("nz", false)};
    if (std::min({position[0], position[1], position[2]}) < 0) source_.Fail("the vertices have no x, y and z");
    const bool has_normal = std::min({normal[0], normal[1], normal[2]}) >= 0;
    PointCloud& cloud = file.cloud;
    cloud.points.reserve(cloud.points.size() + element.count);
    if (has_normal) cloud.normals.reserve(cloud.points.capacity());
    std::vector<double> values(element.properties.size());
    for (std::int64_t i = 0; i < element.count; ++i) {
      ReadOne(element, values, [](std::size_t, double) {});
      const Eigen::Vector3d p(values[position[0]], values[position[1]], values[position[2]]);
      if (!p.allFinite()) source_.Fail("vertex " + std::to_string(i) + " is not finite");
      cloud.points.push_back(p);
      if (has_normal) cloud.normals.push_back({values[normal[0]], values[normal[1]], values[normal[2]]});
    }
  }

  void ReadFaces(const Element& element) {
    int list = element.Find("vertex_indices", true);
    if (list < 0) list = element.Find("vertex_index", true);
    if (list < 0) source_.Fail("the faces have no list vertex_indices");
    const int seen = element.Find("seen", false);
    std::vector<double> values(element.properties.size());
    std::vector<int> ring;
    for (std::int64_t i = 0; i < element.count; ++i) {
      ring.clear();
      ReadOne(element, values, [&](std::size_t property, double value) {
        if (static_cast<int>(property) != list) return;
        if (!(value >= 0.0 && value < static_cast<double>(n_vertices_)) || value != std::floor(value)) {
          source_.Fail("face " + std::to_string(i) + " names a vertex that is not there (there are " +
                       std::to_string(n_vertices_) + ")");
        }
        ring.push_back(static_cast<int>(value));
      });
      if (ring.size() < 3) source_.Fail("face " + std::to_string(i) + " has fewer than three corners");
      polygons.Add(ring);
      if (seen >= 0) polygons.seen.push_back(values[seen] != 0.0 ? 1 : 0);
    }
  }

  void Skip(const Element& element) {
    std::vector<double> values(element.properties.size());
    for (std::int64_t i = 0; i < element.count; ++i) ReadOne(element, values, [](std::size_t, double) {});
  }

  // One element: scalars to `values`, entries of lists to on_entry(property, value).
  template <typename OnEntry>
  void ReadOne(const Element& element, std::vector<double>& values, const OnEntry& on_entry) {
    source_.Begin(element);
    for (std::size_t k = 0; k < element.properties.size(); ++k) {
      const Property& property = element.properties[k];
      if (!property.count_type) {
        values[k] = source_.Value(property.type, property);
        continue;
      }
      const double count = source_.Value(*property.count_type, property);
      if (!(count >= 0.0) || count != std::floor(count)) source_.Fail("the length of a list is no whole number >= 0");
      source_.ExpectRoom(count, property.type, property);
      const auto n = static_cast<std::int64_t>(count);
      for (std::int64_t j = 0; j < n; ++j) on_entry(k, source_.Value(property.type, property));
    }
    source_.End();
  }

  Source& source_;
  std::int64_t n_vertices_ = 0;
};

std::string PlyHeader(const char* vertex_properties, std::size_t n_vertices) {
  return "ply\nformat binary_little_endian 1.0\ncomment written by geond " GEOND_VERSION "\nelement vertex " +
         std::to_string(n_vertices) + "\n" + vertex_properties;
}

constexpr char kPositionProperties[] = "property double x\nproperty double y\nproperty double z\n";
constexpr char kNormalProperties[] = "property double nx\nproperty double ny\nproperty double nz\n";

}  // namespace

bool LooksLikePly(std::string_view bytes) {
  return bytes.size() >= 4 && bytes.substr(0, 3) == "ply" && (bytes[3] == '\n' || bytes[3] == '\r' || bytes[3] == ' ');
}

GeometryFile ReadPly(const FileContent& file) {
  if (!LooksLikePly(file.bytes)) throw FileError(file.name, "read line 1", "it does not begin with \"ply\"");
  LineReader lines(file.bytes, file.name);
  const Header header = ReadHeader(lines);
  if (header.format == Format::kAscii) {
    AsciiSource source(lines);
    PlyBody body(header, source);
    return Assemble(std::move(body.file), body.polygons, file.name);
  }
  BinarySource source(file, lines.position(), header.format == Format::kBigEndian);
  PlyBody body(header, source);
  return Assemble(std::move(body.file), body.polygons, file.name);
}

std::string PlyText(const TriangleMesh& mesh, const std::map<std::string, std::vector<double>>& triangle_values) {
  std::string text = PlyHeader(kPositionProperties, mesh.vertices.size());
  text += "element face " + std::to_string(mesh.triangles.size()) + "\nproperty list uchar int vertex_indices\n";
  const bool has_seen = !mesh.triangle_seen.empty();
  if (has_seen) text += "property uchar seen\n";
  for (const auto& [name, values] : triangle_values) text += "property float " + name + "\n";
  text += "end_header\n";
  for (const Eigen::Vector3d& v : mesh.vertices) {
    for (double c : v) AppendLittleEndian(text, c);
  }
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    text += '\3';
    for (int v : mesh.triangles[t]) AppendLittleEndian(text, static_cast<std::uint32_t>(v));
    if (has_seen) text += static_cast<char>(mesh.triangle_seen[t]);
    for (const auto& [name, values] : triangle_values) AppendLittleEndian(text, static_cast<float>(values[t]));
  }
  return text;
}

std::string PlyText(const PointCloud& cloud) {
  std::string text = PlyHeader(kPositionProperties, cloud.size());
  if (cloud.has_normals()) text += kNormalProperties;
  const bool has_views = !cloud.empty() && cloud.views.size() == cloud.size();
  if (has_views) text += "property int view\n";
  text += "end_header\n";
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    for (double c : cloud.points[i]) AppendLittleEndian(text, c);
    if (cloud.has_normals()) {
      for (double c : cloud.normals[i]) AppendLittleEndian(text, c);
    }
    if (has_views) AppendLittleEndian(text, static_cast<std::uint32_t>(cloud.views[i]));
  }
  return text;
}

}  // namespace geond
