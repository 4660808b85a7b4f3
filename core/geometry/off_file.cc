// SPDX-License-Identifier: Apache-2.0
// OFF, the object file format of Geomview: "OFF" (with C, N, ST before it if vertices carry colours, normals, texture),
// the numbers of vertices, faces and edges, then a line a vertex and a line a face.
#include <algorithm>

#include "core/base/error.h"
#include "core/geometry/file_formats.h"
#include "core/geometry/line_reader.h"

namespace geond {
namespace {

struct Kind {
  bool recognised = false;
  bool normals = false;
  bool four_dimensional = false;
  std::size_t length = 0;  // of the keyword
};

Kind ParseKeyword(std::string_view bytes) {
  Kind kind;
  std::size_t at = 0;
  const auto take = [&](std::string_view word) {
    if (bytes.substr(at, word.size()) != word) return false;
    at += word.size();
    return true;
  };
  take("ST");
  take("C");
  kind.normals = take("N");
  kind.four_dimensional = take("4");
  if (take("n")) kind.four_dimensional = true;
  kind.recognised = take("OFF");
  kind.length = at;
  return kind;
}

}  // namespace

bool LooksLikeOff(std::string_view bytes) { return ParseKeyword(bytes).recognised; }

GeometryFile ReadOff(const FileContent& content) {
  LineReader lines(content.bytes, content.name);
  if (!lines.Next("#")) lines.Fail("the file is empty");
  const Kind kind = ParseKeyword(lines.rest());
  if (!kind.recognised) lines.Fail("it does not begin with \"OFF\"");
  if (kind.four_dimensional) lines.Fail("points of four or more coordinates are not read");
  lines.rest().remove_prefix(kind.length);
  if (lines.rest().find("BINARY") != std::string_view::npos)
    lines.Fail("the binary form of OFF is not read", "Save it as PLY or as text");
  if (!lines.MoreOnLine() && !lines.Next("#")) lines.Fail("the file ends where the counts are wanted");

  const std::int64_t n_vertices = lines.Integer("the number of vertices");
  const std::int64_t n_faces = lines.Integer("the number of faces");
  // "0 0 0\n" is the shortest vertex, "3 0 0 0\n" the shortest face.
  const auto room = static_cast<std::int64_t>(lines.remaining()) + 1;
  if (n_vertices < 0 || n_faces < 0 || n_vertices > room / 6 || n_faces > room / 8 ||
      6 * n_vertices + 8 * n_faces > room) {
    lines.Fail("the header says " + std::to_string(n_vertices) + " vertices and " + std::to_string(n_faces) +
                   " faces, more than the file can hold",
               "It may have been cut off");
  }

  GeometryFile file;
  file.cloud.points.reserve(n_vertices);
  for (std::int64_t i = 0; i < n_vertices; ++i) {
    if (!lines.Next("#"))
      lines.Fail("the file ends after " + std::to_string(i) + " of " + std::to_string(n_vertices) + " vertices");
    Eigen::Vector3d p;
    for (int k = 0; k < 3; ++k) p[k] = lines.Number("a coordinate");
    if (!p.allFinite()) lines.Fail("the vertex is not finite");
    file.cloud.points.push_back(p);
    if (!kind.normals) continue;
    for (int k = 0; k < 3; ++k) p[k] = lines.Number("a normal");
    file.cloud.normals.push_back(p);
  }
  PolygonList polygons;
  std::vector<int> ring;
  for (std::int64_t i = 0; i < n_faces; ++i) {
    if (!lines.Next("#"))
      lines.Fail("the file ends after " + std::to_string(i) + " of " + std::to_string(n_faces) + " faces");
    const std::int64_t n = lines.Integer("the number of corners");
    if (n < 3) lines.Fail("a face of fewer than three corners");
    if (n > static_cast<std::int64_t>(lines.rest().size())) lines.Fail("the line is too short for its corners");
    ring.clear();
    for (std::int64_t k = 0; k < n; ++k) {
      const std::int64_t v = lines.Integer("a corner");
      if (v < 0 || v >= n_vertices) {
        lines.Fail("the face names vertex " + std::to_string(v) + " of " + std::to_string(n_vertices));
      }
      ring.push_back(static_cast<int>(v));
    }
    polygons.Add(ring);
  }
  if (lines.Next("#")) lines.Fail("there is more in the file than its counts say");
  return Assemble(std::move(file), polygons, content.name);
}

std::string OffText(const TriangleMesh& mesh) {
  std::string text =
      "OFF\n" + std::to_string(mesh.vertices.size()) + " " + std::to_string(mesh.triangles.size()) + " 0\n";
  for (const Eigen::Vector3d& v : mesh.vertices) {
    for (int k = 0; k < 3; ++k) {
      AppendNumber(text, v[k]);
      text += k < 2 ? ' ' : '\n';
    }
  }
  for (const TriangleMesh::Triangle& t : mesh.triangles) {
    text += '3';
    for (int v : t) {
      text += ' ';
      AppendNumber(text, v);
    }
    text += '\n';
  }
  return text;
}

}  // namespace geond
