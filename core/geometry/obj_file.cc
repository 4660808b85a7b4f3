// SPDX-License-Identifier: Apache-2.0
// OBJ, Wavefront's text format: of it vertices (v), normals (vn) and faces (f v, v/vt, v/vt/vn, v//vn; counted from 1,
// or backwards from -1) are read, all else is passed over.
#include <algorithm>

#include "core/base/error.h"
#include "core/geometry/file_formats.h"
#include "core/geometry/line_reader.h"

namespace geond {
namespace {

bool IsKeyword(std::string_view word) {
  return std::all_of(word.begin(), word.end(),
                     [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; });
}

// The number of lines that begin with "v ": what the indices of faces may reach.
std::int64_t CountVertices(std::string_view text, const std::string& name) {
  LineReader lines(text, name);
  std::int64_t n = 0;
  while (lines.Next("#")) n += lines.Word() == "v";
  return n;
}

}  // namespace

GeometryFile ReadObj(const FileContent& content) {
  GeometryFile file;
  PolygonList polygons;
  std::vector<Eigen::Vector3d> normals;
  const std::int64_t n_vertices = CountVertices(content.bytes, content.name);
  LineReader lines(content.bytes, content.name);
  std::vector<int> ring;

  // The corners on the line, and on the next ones while a line ends with a backslash.
  const auto read_face = [&] {
    ring.clear();
    for (;;) {
      const std::string_view word = lines.Word();
      if (word == "\\") {
        if (!lines.Next("#")) lines.Fail("the file ends in a face");
        continue;
      }
      if (word.empty()) break;
      std::int64_t index = 0;
      if (!ParseInteger(word.substr(0, word.find('/')), index) || index == 0) {
        lines.Fail(Quoted(word) + " names no vertex (they are counted from 1, or backwards from -1)");
      }
      const auto read_so_far = static_cast<std::int64_t>(file.cloud.points.size());
      const std::int64_t v = index > 0 ? index - 1 : read_so_far + index;
      if (v < 0 || v >= n_vertices) {
        lines.Fail("the face names vertex " + std::to_string(index) + ", but there are " + std::to_string(n_vertices));
      }
      ring.push_back(static_cast<int>(v));
    }
    if (ring.size() < 3) lines.Fail("a face of fewer than three corners");
    polygons.Add(ring);
  };
  const auto read_point = [&](const char* what) {
    Eigen::Vector3d p;
    for (int k = 0; k < 3; ++k) p[k] = lines.Number(what);
    if (!p.allFinite()) lines.Fail(std::string(what) + " is not finite");
    return p;
  };

  while (lines.Next("#")) {
    const std::string_view key = lines.Word();
    if (key == "v")
      file.cloud.points.push_back(read_point("a coordinate"));
    else if (key == "vn")
      normals.push_back(read_point("a normal"));
    else if (key == "f" || key == "fo")
      read_face();
    else if (!IsKeyword(key))
      lines.Fail("unknown keyword " + Quoted(key), "Is it an OBJ file?");
  }
  // Normals of faces' corners are of no use here; of a cloud, they stand beside the points.
  if (polygons.sizes.empty() && normals.size() == file.cloud.points.size()) file.cloud.normals = std::move(normals);
  return Assemble(std::move(file), polygons, content.name);
}

std::string ObjText(const TriangleMesh& mesh) {
  std::string text = "# written by geond " GEOND_VERSION "\n";
  for (const Eigen::Vector3d& v : mesh.vertices) {
    text += 'v';
    for (double c : v) {
      text += ' ';
      AppendNumber(text, c);
    }
    text += '\n';
  }
  for (const TriangleMesh::Triangle& t : mesh.triangles) {
    text += 'f';
    for (int v : t) {
      text += ' ';
      AppendNumber(text, v + 1);
    }
    text += '\n';
  }
  return text;
}

}  // namespace geond
