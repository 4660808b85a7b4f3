// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <numeric>
#include <tuple>

#include "core/base/error.h"
#include "core/geometry/file_formats.h"

namespace geond {
namespace {

using Ring = std::vector<int>;
using Triangle = TriangleMesh::Triangle;

constexpr std::size_t kMostEarCorners = 2000;  // cutting ears is quadratic; larger rings become fans

void Fan(const Ring& ring, std::vector<Triangle>& triangles) {
  for (std::size_t k = 1; k + 1 < ring.size(); ++k) triangles.push_back({ring[0], ring[k], ring[k + 1]});
}

double Cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c) {
  return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
}

// Cuts ears off the polygon, seen along its mean normal (Newell's). False if it is too twisted for that.
bool CutEars(const std::vector<Eigen::Vector3d>& points, Ring ring, std::vector<Triangle>& triangles) {
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  for (std::size_t k = 0; k < ring.size(); ++k) {
    const Eigen::Vector3d a = points[ring[k]] - points[ring[0]],
                          b = points[ring[(k + 1) % ring.size()]] - points[ring[0]];
    normal += a.cross(b);
  }
  if (!(normal.norm() > 0.0) || !normal.allFinite()) return false;
  normal.normalize();
  const Eigen::Vector3d x = normal.unitOrthogonal(), y = normal.cross(x);
  std::vector<Eigen::Vector2d> flat;
  for (int v : ring) flat.push_back({(points[v] - points[ring[0]]).dot(x), (points[v] - points[ring[0]]).dot(y)});

  const std::size_t first = triangles.size();
  while (ring.size() > 3) {
    const std::size_t n = ring.size();
    std::size_t ear = n;
    for (std::size_t k = 0; k < n && ear == n; ++k) {
      const Eigen::Vector2d &a = flat[(k + n - 1) % n], &b = flat[k], &c = flat[(k + 1) % n];
      if (!(Cross(a, b, c) > 0.0)) continue;
      bool empty = true;
      for (std::size_t other = 0; other < n && empty; ++other) {
        if (other == k || other == (k + 1) % n || other == (k + n - 1) % n) continue;
        const Eigen::Vector2d& p = flat[other];
        empty = Cross(a, b, p) < 0.0 || Cross(b, c, p) < 0.0 || Cross(c, a, p) < 0.0;
      }
      if (empty) ear = k;
    }
    if (ear == n) {
      triangles.resize(first);
      return false;
    }
    triangles.push_back({ring[(ear + n - 1) % n], ring[ear], ring[(ear + 1) % n]});
    ring.erase(ring.begin() + static_cast<std::ptrdiff_t>(ear));
    flat.erase(flat.begin() + static_cast<std::ptrdiff_t>(ear));
  }
  triangles.push_back({ring[0], ring[1], ring[2]});
  return true;
}

// Whether a fan from the first corner gives triangles that all face the same way.
bool FanIsConvex(const std::vector<Eigen::Vector3d>& points, const Ring& ring) {
  Eigen::Vector3d first = Eigen::Vector3d::Zero();
  for (std::size_t k = 1; k + 1 < ring.size(); ++k) {
    const Eigen::Vector3d area = (points[ring[k]] - points[ring[0]]).cross(points[ring[k + 1]] - points[ring[0]]);
    if (k == 1) first = area;
    if (!(area.dot(first) > 0.0)) return false;
  }
  return true;
}

void MakeTriangles(GeometryFile& file, const PolygonList& polygons) {
  std::vector<Triangle>& triangles = file.mesh.triangles;
  triangles.reserve(polygons.sizes.size());
  std::size_t n_split = 0, n_dropped = 0, begin = 0;
  Ring ring;
  for (std::size_t face = 0; face < polygons.sizes.size(); ++face) {
    const std::size_t end = begin + polygons.sizes[face];
    ring.assign(polygons.corners.begin() + static_cast<std::ptrdiff_t>(begin),
                polygons.corners.begin() + static_cast<std::ptrdiff_t>(end));
    begin = end;
    ring.erase(std::unique(ring.begin(), ring.end()), ring.end());
    while (ring.size() > 1 && ring.front() == ring.back()) ring.pop_back();
    if (ring.size() < 3) {
      ++n_dropped;
      continue;
    }
    if (ring.size() == 3) {
      triangles.push_back({ring[0], ring[1], ring[2]});
    } else {
      ++n_split;
      if (FanIsConvex(file.cloud.points, ring) || ring.size() > kMostEarCorners ||
          !CutEars(file.cloud.points, ring, triangles)) {
        Fan(ring, triangles);
      }
    }
    if (!polygons.seen.empty()) file.mesh.triangle_seen.resize(triangles.size(), polygons.seen[face]);
  }
  if (n_split > 0) file.notes.push_back(std::to_string(n_split) + " polygons were split into triangles");
  if (n_dropped > 0)
    file.notes.push_back((n_dropped == 1 ? "a face" : std::to_string(n_dropped) + " faces") +
                         std::string(" without area (a corner named twice) ") + (n_dropped == 1 ? "was" : "were") +
                         " left out");
}

// Normals become unit. Where some have no length: points without one are left out of a cloud if they are few, else the
// normals are.
void MendNormals(GeometryFile& file) {
  std::vector<Eigen::Vector3d>& normals = file.cloud.normals;
  if (normals.empty()) return;
  std::vector<int> usable;
  for (std::size_t i = 0; i < normals.size(); ++i) {
    const double length = normals[i].norm();
    if (!std::isfinite(length) || !(length > 1e-6)) continue;
    if (std::abs(length - 1.0) > 1e-12) normals[i] /= length;
    usable.push_back(static_cast<int>(i));
  }
  const std::size_t n_bad = normals.size() - usable.size();
  if (n_bad == 0) return;
  if (!file.has_faces() && 10 * n_bad <= normals.size()) {
    file.cloud = Select(file.cloud, usable);
    file.notes.push_back(std::to_string(n_bad) + " points without a usable normal were left out");
  } else {
    normals.clear();
    file.notes.push_back("the normals were not used: " + std::to_string(n_bad) + " of them have no length");
  }
}

bool IsOpen(const TriangleMesh& mesh) {
  for (const std::array<int, 3>& neighbors : TriangleNeighbors(mesh)) {
    if (*std::min_element(neighbors.begin(), neighbors.end()) < 0) return true;
  }
  return false;
}

// Modellers part the surface where texture or normal jumps, with a vertex of its own for each side.
void WeldSeams(GeometryFile& file) {
  TriangleMesh welded;
  const std::vector<int> vertex = WeldEqualPoints(file.mesh.vertices, welded.vertices);
  if (welded.vertices.size() == file.mesh.vertices.size()) return;
  welded.triangle_seen = file.mesh.triangle_seen;
  for (const Triangle& t : file.mesh.triangles) {
    welded.triangles.push_back({vertex[t[0]], vertex[t[1]], vertex[t[2]]});
    const Triangle& w = welded.triangles.back();
    if (w[0] == w[1] || w[1] == w[2] || w[2] == w[0]) return;
  }
  file.notes.push_back(std::to_string(file.mesh.vertices.size() - welded.vertices.size()) +
                       " vertices at the place of others were welded");
  file.mesh = std::move(welded);
}

template <typename Unsigned>
void AppendBits(std::string& bytes, Unsigned bits) {
  for (std::size_t k = 0; k < sizeof(bits); ++k) bytes += static_cast<char>(bits >> (8 * k) & 0xff);
}

}  // namespace

GeometryFile Assemble(GeometryFile file, const PolygonList& polygons, const std::string& name) {
  if (file.cloud.points.empty()) throw FileError(name, "read", "there are no points in it");
  MakeTriangles(file, polygons);
  if (!polygons.sizes.empty() && !file.has_faces()) throw FileError(name, "read", "none of its faces has an area");
  MendNormals(file);
  if (!file.has_faces()) return file;
  file.mesh.vertices = file.cloud.points;
  if (IsOpen(file.mesh)) WeldSeams(file);
  return file;
}

std::vector<int> WeldEqualPoints(const std::vector<Eigen::Vector3d>& points, std::vector<Eigen::Vector3d>& distinct) {
  std::vector<int> order(points.size());
  std::iota(order.begin(), order.end(), 0);
  const auto key = [&](int i) { return std::tie(points[i].x(), points[i].y(), points[i].z()); };
  std::sort(order.begin(), order.end(), [&](int a, int b) { return key(a) != key(b) ? key(a) < key(b) : a < b; });
  std::vector<int> first(points.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    first[order[i]] = i > 0 && points[order[i]] == points[order[i - 1]] ? first[order[i - 1]] : order[i];
  }
  distinct.clear();
  std::vector<int> index(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (first[i] == static_cast<int>(i)) {
      index[i] = static_cast<int>(distinct.size());
      distinct.push_back(points[i] + Eigen::Vector3d::Zero());  // -0 becomes 0
    } else {
      index[i] = index[first[i]];
    }
  }
  return index;
}

void AppendNumber(std::string& text, double value) {
  char digits[32];
  text.append(digits, std::to_chars(digits, digits + sizeof(digits), value).ptr);
}

void AppendNumber(std::string& text, int value) {
  char digits[16];
  text.append(digits, std::to_chars(digits, digits + sizeof(digits), value).ptr);
}

void AppendLittleEndian(std::string& bytes, float value) { AppendBits(bytes, std::bit_cast<std::uint32_t>(value)); }
void AppendLittleEndian(std::string& bytes, double value) { AppendBits(bytes, std::bit_cast<std::uint64_t>(value)); }
void AppendLittleEndian(std::string& bytes, std::uint32_t value) { AppendBits(bytes, value); }

float FloatAt(std::string_view bytes, std::size_t position) {
  return std::bit_cast<float>(Unsigned32At(bytes, position));
}

std::uint32_t Unsigned32At(std::string_view bytes, std::size_t position) {
  std::uint32_t bits = 0;
  for (int k = 3; k >= 0; --k) bits = bits << 8 | static_cast<unsigned char>(bytes[position + k]);
  return bits;
}

}  // namespace geond
