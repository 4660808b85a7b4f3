// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "core/geometry/mesh_files.h"

namespace geond {

// A file's bytes, and its name for errors. One reader and writer a format, each in a file of its own; mesh_files.cc
// chooses.
struct FileContent {
  std::string_view bytes;
  std::string name;
};

GeometryFile ReadPly(const FileContent& file);
GeometryFile ReadOff(const FileContent& file);
GeometryFile ReadObj(const FileContent& file);
GeometryFile ReadStl(const FileContent& file);
GeometryFile ReadPcd(const FileContent& file);
GeometryFile ReadXyz(const FileContent& file);

bool LooksLikePly(std::string_view bytes);
bool LooksLikeOff(std::string_view bytes);
bool LooksLikePcd(std::string_view bytes);
bool LooksLikeStl(std::string_view bytes);

std::string PlyText(const TriangleMesh& mesh, const std::map<std::string, std::vector<double>>& triangle_values);
std::string PlyText(const PointCloud& cloud);
std::string OffText(const TriangleMesh& mesh);
std::string ObjText(const TriangleMesh& mesh);
std::string StlText(const TriangleMesh& mesh);
std::string PcdText(const PointCloud& cloud);
std::string XyzText(const PointCloud& cloud);

// The faces of a file as they stand there, each with three corners or more, indices within the vertices.
struct PolygonList {
  std::vector<int> corners;        // of all faces, one after the other
  std::vector<int> sizes;          // corners of each face
  std::vector<std::uint8_t> seen;  // one a face, or empty
  void Add(const std::vector<int>& ring) {
    corners.insert(corners.end(), ring.begin(), ring.end());
    sizes.push_back(static_cast<int>(ring.size()));
  }
};

// What every reader does at the end: `file.cloud` holds points (and normals as they stood in the file), `polygons` the
// faces. Splits polygons into triangles (ears, so that concave ones come out right), leaves out faces that name a
// vertex twice in a row and normals of no length, welds equal vertices of a mesh that is not closed as it stands, and
// notes what it did. Throws FileError if there are no points.
GeometryFile Assemble(GeometryFile file, const PolygonList& polygons, const std::string& name);

// For each point the index of the one in `distinct` that equals it to the bit (0 and -0 are equal); `distinct` are in
// the order in which they first appear.
std::vector<int> WeldEqualPoints(const std::vector<Eigen::Vector3d>& points, std::vector<Eigen::Vector3d>& distinct);

// Appends the shortest decimal that reads back as the same number.
void AppendNumber(std::string& text, double value);
void AppendNumber(std::string& text, int value);
// Appends and reads little-endian bytes of a number, whatever the machine's order.
void AppendLittleEndian(std::string& bytes, float value);
void AppendLittleEndian(std::string& bytes, double value);
void AppendLittleEndian(std::string& bytes, std::uint32_t value);
float FloatAt(std::string_view bytes, std::size_t position);
std::uint32_t Unsigned32At(std::string_view bytes, std::size_t position);

}  // namespace geond
