// SPDX-License-Identifier: Apache-2.0
// STL, the stereolithography format: loose triangles, binary (80 bytes of header, a count, 50 bytes a triangle) or
// text. The two are told apart by the size, since binary files may begin with "solid" too. Equal corners are welded.
#include "core/base/error.h"
#include "core/geometry/file_formats.h"
#include "core/geometry/line_reader.h"

namespace geond {
namespace {

constexpr std::size_t kHeaderBytes = 84, kTriangleBytes = 50;

bool IsBinary(std::string_view bytes) {
  return bytes.size() >= kHeaderBytes &&
         bytes.size() == kHeaderBytes + kTriangleBytes * std::size_t{Unsigned32At(bytes, 80)};
}

std::string Lower(std::string_view word) {
  std::string lower(word);
  for (char& c : lower) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return lower;
}

std::vector<Eigen::Vector3d> BinaryCorners(const FileContent& content) {
  std::vector<Eigen::Vector3d> corners;
  const std::size_t n = Unsigned32At(content.bytes, 80);
  corners.reserve(3 * n);
  for (std::size_t t = 0; t < n; ++t) {
    for (int k = 0; k < 3; ++k) {
      const std::size_t at = kHeaderBytes + kTriangleBytes * t + 12 + 12 * k;
      const Eigen::Vector3d p(FloatAt(content.bytes, at), FloatAt(content.bytes, at + 4),
                              FloatAt(content.bytes, at + 8));
      if (!p.allFinite()) {
        throw FileError(content.name, "read byte " + std::to_string(at),
                        "a corner of triangle " + std::to_string(t) + " is not finite");
      }
      corners.push_back(p);
    }
  }
  return corners;
}

std::vector<Eigen::Vector3d> TextCorners(const FileContent& content) {
  std::vector<Eigen::Vector3d> corners;
  LineReader lines(content.bytes, content.name);
  int corners_of_facet = -1;  // -1: outside of any
  bool ended = false;
  while (lines.Next()) {
    const std::string key = Lower(lines.Word());
    if (key == "vertex") {
      if (corners_of_facet < 0) lines.Fail("a vertex outside of a facet");
      if (++corners_of_facet > 3) lines.Fail("a facet of more than three vertices");
      Eigen::Vector3d p;
      for (int k = 0; k < 3; ++k) p[k] = lines.Number("a coordinate");
      if (!p.allFinite()) lines.Fail("the vertex is not finite");
      corners.push_back(p);
    } else if (key == "facet") {
      if (corners_of_facet >= 0) lines.Fail("a facet within a facet");
      corners_of_facet = 0;
    } else if (key == "endfacet") {
      if (corners_of_facet != 3) lines.Fail("a facet that has not three vertices");
      corners_of_facet = -1;
    } else if (key == "endsolid") {
      ended = true;
    } else if (key == "solid") {
      ended = false;
    } else if (key != "outer" && key != "endloop") {
      lines.Fail("unknown keyword " + Quoted(key));
    }
  }
  if (corners_of_facet >= 0 || !ended) lines.Fail("the file ends without endsolid", "It may have been cut off");
  return corners;
}

}  // namespace

bool LooksLikeStl(std::string_view bytes) { return IsBinary(bytes) || Lower(bytes.substr(0, 5)) == "solid"; }

GeometryFile ReadStl(const FileContent& content) {
  const std::string_view bytes = content.bytes;
  if (!LooksLikeStl(bytes)) {
    if (bytes.size() < kHeaderBytes) {
      throw FileError(content.name, "read byte " + std::to_string(bytes.size()),
                      "the file ends within the header of a binary STL", "It may have been cut off");
    }
    throw FileError(content.name, "read byte 80",
                    "the header says " + std::to_string(Unsigned32At(bytes, 80)) + " triangles of 50 bytes, but " +
                        std::to_string(bytes.size() - kHeaderBytes) + " bytes follow",
                    "It may have been cut off");
  }
  const std::vector<Eigen::Vector3d> corners = IsBinary(bytes) ? BinaryCorners(content) : TextCorners(content);
  GeometryFile file;
  PolygonList polygons;
  polygons.corners = WeldEqualPoints(corners, file.cloud.points);
  polygons.sizes.assign(corners.size() / 3, 3);
  return Assemble(std::move(file), polygons, content.name);
}

std::string StlText(const TriangleMesh& mesh) {
  std::string bytes = "binary STL written by geond " GEOND_VERSION;
  bytes.resize(80, ' ');
  AppendLittleEndian(bytes, static_cast<std::uint32_t>(mesh.triangles.size()));
  const std::vector<Eigen::Vector3d> normals = TriangleNormals(mesh);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (double c : normals[t]) AppendLittleEndian(bytes, static_cast<float>(c));
    for (int v : mesh.triangles[t]) {
      for (double c : mesh.vertices[v]) AppendLittleEndian(bytes, static_cast<float>(c));
    }
    bytes += std::string(2, '\0');
  }
  return bytes;
}

}  // namespace geond
