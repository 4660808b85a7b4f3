// SPDX-License-Identifier: Apache-2.0
// Two caps, each a grid, joined by rings: a cube's surface for the cuboid, the same bulged for the ellipsoid, the caps mapped
// to discs for the cylinder. Every vertex is carried along its ray to the surface, then deformed.
#include "core/geon/geon_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <utility>
#include <vector>

#include "core/geon/shape.h"

namespace geond {
namespace {

constexpr double kTurn = std::numbers::pi / 12.0;  // the surface turns no more than about this from line to line
constexpr double kRimStart = 0.85;                 // where a cap or side of exponent 0.1 begins to turn into the edge
constexpr int kMaxLines = 2000;

// Lines over [-1, 1], symmetric: `count` cells between the rims, and lines inside the rims (1 - kRimStart of a half side) if
// the edges are sharp.
std::vector<double> Lines(double half_length, double edge_length, bool sharp, int least) {
  const auto cells = [&](double length) {
    return std::clamp(static_cast<int>(std::ceil(length / edge_length - 1e-9)), 1, kMaxLines);
  };
  std::vector<double> lines;
  if (!sharp) {
    const int n = std::max(least, cells(2.0 * half_length));
    for (int i = 0; i <= n; ++i) lines.push_back(-1.0 + 2.0 * i / n);
    return lines;
  }
  const int n = std::max(least, cells(2.0 * half_length * kRimStart));
  // tan of the turn is u^19: lines at equal turns from kRimStart on, more if the edge length asks for it.
  const int rim = std::max(3, cells(half_length * (1.0 - kRimStart)));
  for (int i = rim; i > 0; --i) lines.push_back(-std::pow(std::tan(std::numbers::pi / 4.0 * i / rim), 1.0 / 19.0));
  const double inner = 0.5 * (kRimStart - lines.back());
  for (int i = 0; i <= n; ++i) lines.push_back(inner * (-1.0 + 2.0 * i / n));
  for (int i = 1; i <= rim; ++i) lines.push_back(std::pow(std::tan(std::numbers::pi / 4.0 * i / rim), 1.0 / 19.0));
  lines.front() = -1.0;
  lines.back() = 1.0;
  return lines;
}

// The square's concentric squares to concentric circles.
Eigen::Vector2d SquareToDisc(double u, double v) {
  if (u == 0.0 && v == 0.0) return Eigen::Vector2d::Zero();
  const double quarter = std::numbers::pi / 4.0;
  if (std::abs(u) >= std::abs(v)) return u * Eigen::Vector2d(std::cos(quarter * v / u), std::sin(quarter * v / u));
  return v * Eigen::Vector2d(std::sin(quarter * u / v), std::cos(quarter * u / v));
}

// The mesh of two caps of columns x rows cells and the rings between their borders, each vertex made once.
class CapsAndRings {
 public:
  // `cap(i, j, top)`: position of a grid point of a cap; `ring(i, j, k)`: of perimeter point (i, j) on ring k.
  template <typename Cap, typename Ring>
  CapsAndRings(int columns, int rows, int rings, const Cap& cap, const Ring& ring) : columns_(columns) {
    std::vector<std::pair<int, int>> loop;   // counter-clockwise seen from +z
    for (int i = 0; i < columns; ++i) loop.emplace_back(i, 0);
    for (int j = 0; j < rows; ++j) loop.emplace_back(columns, j);
    for (int i = columns; i > 0; --i) loop.emplace_back(i, rows);
    for (int j = rows; j > 0; --j) loop.emplace_back(0, j);
    const int perimeter = static_cast<int>(loop.size());
    // Rings from the bottom up; the first and last are the caps' borders.
    for (int k = 0; k <= rings; ++k) {
      for (const auto& [i, j] : loop) mesh.vertices.push_back(ring(i, j, k));
    }
    for (int k = 0; k < rings; ++k) {
      for (int l = 0; l < perimeter; ++l) {
        const int a = k * perimeter + l, b = k * perimeter + (l + 1) % perimeter;
        Quad(a, b, b + perimeter, a + perimeter, (l + k) % 2 == 0);
      }
    }
    for (const bool top : {false, true}) {
      std::vector<int> index(static_cast<std::size_t>(columns + 1) * (rows + 1), -1);
      for (int l = 0; l < perimeter; ++l) index[At(loop[l].first, loop[l].second)] = (top ? rings * perimeter : 0) + l;
      for (int j = 1; j < rows; ++j) {
        for (int i = 1; i < columns; ++i) {
          index[At(i, j)] = static_cast<int>(mesh.vertices.size());
          mesh.vertices.push_back(cap(i, j, top));
        }
      }
      for (int j = 0; j < rows; ++j) {
        for (int i = 0; i < columns; ++i) {
          // The diagonal runs towards the corner of the cap, so that a corner cell bent round a circle stays two triangles.
          const bool rising = (2 * i + 1 < columns) == (2 * j + 1 < rows);
          const int a = index[At(i, j)], b = index[At(i + 1, j)], c = index[At(i + 1, j + 1)], d = index[At(i, j + 1)];
          top ? Quad(a, b, c, d, rising) : Quad(a, d, c, b, rising);
        }
      }
    }
  }
  RegularMesh mesh;

 private:
  int At(int i, int j) const { return j * (columns_ + 1) + i; }
  void Quad(int a, int b, int c, int d, bool along_ac) {
    if (along_ac) {
      mesh.triangles.push_back({a, b, c});
      mesh.triangles.push_back({a, c, d});
    } else {
      mesh.triangles.push_back({a, b, d});
      mesh.triangles.push_back({b, c, d});
    }
  }
  int columns_;
};

}  // namespace

RegularMesh MeshRegularPrimitive(const Geon& geon, double edge_length) {
  if (!(edge_length > 0.0)) throw std::invalid_argument("the edge length of a geon's mesh must be positive");
  CheckGeon(geon);
  const Eigen::Vector3d& a = geon.size;
  // Lengths as deformed: the wider end of a taper, the outer side of a bend.
  Eigen::Vector3d length = a;
  if (IsTapered(geon.type)) length.head<2>().array() *= 1.0 + geon.taper.array();
  if (IsCurved(geon.type)) length.z() *= 1.0 + geon.bend * a.x();
  int least_z = 1;
  if (IsCurved(geon.type)) least_z = static_cast<int>(std::ceil(2.0 * geon.bend * a.z() / kTurn));

  const auto on_surface = [&](const Eigen::Vector3d& direction) {
    const Eigen::Vector3d p = direction.cwiseProduct(a);
    return Eigen::Vector3d(p / Gauge(geon, p));
  };
  if (BaseType(geon.type) == GeonType::kCylinder) {
    const double radius = length.head<2>().maxCoeff();
    const int n = std::clamp(static_cast<int>(std::ceil(0.5 * std::numbers::pi * radius / edge_length)), 6, kMaxLines);
    const std::vector<double> z = Lines(length.z(), edge_length, true, least_z);
    // Rings: over the bottom rim, up the side, over the top rim; the caps' discs lie within.
    std::vector<std::pair<double, double>> profile;
    const std::vector<double> r = Lines(radius, edge_length, true, 1);
    std::vector<double> rim;
    for (const double v : r) if (v > kRimStart * 0.9) rim.push_back(v);
    for (const double v : rim) profile.emplace_back(v, -1.0);
    for (std::size_t k = 1; k < z.size(); ++k) profile.emplace_back(1.0, z[k]);
    for (auto v = rim.rbegin() + 1; v != rim.rend(); ++v) profile.emplace_back(*v, 1.0);
    const auto uv = [n](int i) { return -1.0 + 2.0 * i / n; };
    return CapsAndRings(
        n, n, static_cast<int>(profile.size()) - 1,
        [&](int i, int j, bool top) {
          const Eigen::Vector2d d = rim.front() * SquareToDisc(uv(i), uv(j));
          return on_surface({d.x(), d.y(), top ? 1.0 : -1.0});
        },
        [&](int i, int j, int k) {
          const Eigen::Vector2d d = profile[k].first * SquareToDisc(uv(i), uv(j));
          return on_surface({d.x(), d.y(), profile[k].second});
        }).mesh;
  }
  const bool sharp = BaseType(geon.type) == GeonType::kCuboid;
  std::array<std::vector<double>, 3> lines;
  for (int k = 0; k < 3; ++k) {
    // A quarter of an ellipse lies over each half side.
    const double half = sharp ? length[k] : 0.5 * std::numbers::pi / std::sqrt(2.0) * length[k];
    lines[k] = Lines(half, edge_length, sharp, sharp ? (k == 2 ? least_z : 1) : 6);
    if (!sharp) for (double& u : lines[k]) u = std::tan(std::numbers::pi / 4.0 * u);
  }
  return CapsAndRings(
      static_cast<int>(lines[0].size()) - 1, static_cast<int>(lines[1].size()) - 1, static_cast<int>(lines[2].size()) - 1,
      [&](int i, int j, bool top) { return on_surface({lines[0][i], lines[1][j], top ? 1.0 : -1.0}); },
      [&](int i, int j, int k) { return on_surface({lines[0][i], lines[1][j], lines[2][k]}); }).mesh;
}

TriangleMesh GeonMesh(const Geon& geon, double edge_length) {
  const RegularMesh regular = MeshRegularPrimitive(geon, edge_length);
  TriangleMesh mesh;
  mesh.triangles = regular.triangles;
  mesh.vertices.reserve(regular.vertices.size());
  for (const Eigen::Vector3d& x : regular.vertices) mesh.vertices.push_back(geon.X_TG * Deform(geon, x));
  return mesh;
}

}  // namespace geond
