// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "core/geometry/point_cloud.h"
#include "core/geometry/triangle_mesh.h"

namespace geond {

// What a file held: a mesh if it has faces, else a cloud. Coordinates in the file's own unit, not yet metres.
struct GeometryFile {
  PointCloud cloud;   // the points (a mesh's vertices, as they stand in the file), with normals if the file has them
  TriangleMesh mesh;  // empty if there are no faces; polygons are split into triangles
  std::vector<std::string> notes;  // what was dropped or mended, for a person
  bool has_faces() const { return !mesh.triangles.empty(); }
};

// Reads PLY (ascii, both binaries), OFF, OBJ, STL (ascii, binary), PCD (ascii, binary, compressed), XYZ (columns x y z
// [nx ny nz]), by content and ending. Equal vertices are welded in STL, and in a mesh that is not closed as it stands.
// Throws FileError, naming line or byte, on anything broken; never allocates more than the file's size justifies.
GeometryFile ReadGeometry(const std::filesystem::path& path);
// The same from a file's bytes in memory; `path` gives the ending and the name for errors.
GeometryFile ParseGeometry(std::string_view bytes, const std::filesystem::path& path);

// Writes by the ending: .ply (binary little-endian) .off .obj .stl (binary). `triangle_values` (PLY only): float
// properties a face, by name. Throws FileError.
void WriteMesh(const TriangleMesh& mesh, const std::filesystem::path& path,
               const std::map<std::string, std::vector<double>>& triangle_values = {});
// Writes by the ending: .ply (binary little-endian) .pcd .xyz, with normals if there are any. Throws FileError.
void WriteCloud(const PointCloud& cloud, const std::filesystem::path& path);

// The same shape with every length times `factor` (0.001: millimetres to metres).
GeometryFile Scaled(GeometryFile file, double factor);

}  // namespace geond
