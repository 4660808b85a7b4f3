// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>
#include <vector>

#include "core/geometry/triangle_mesh.h"

// Meshes of shapes whose charge is known, for tests, benchmarks and validation.
namespace geond::shapes {

using Eigen::Vector3d;
inline constexpr double kPi = std::numbers::pi;
inline constexpr double kPeanutCapacitance = 1.2928932188134525;  // 2 - 1/sqrt 2

// The surface of a grid of rows by columns closed in both directions.
template <typename Point>
TriangleMesh ClosedGrid(int rows, int columns, const Point& point) {
  TriangleMesh mesh;
  for (int i = 0; i < rows; ++i) {
    for (int j = 0; j < columns; ++j) mesh.vertices.push_back(point(i, j));
  }
  const auto index = [&](int i, int j) { return (i % rows) * columns + j % columns; };
  for (int i = 0; i < rows; ++i) {
    for (int j = 0; j < columns; ++j) {
      mesh.triangles.push_back({index(i, j), index(i + 1, j), index(i + 1, j + 1)});
      mesh.triangles.push_back({index(i, j), index(i + 1, j + 1), index(i, j + 1)});
    }
  }
  return mesh;
}

// The unit sphere: an icosahedron whose edges are cut into 2^levels, 20 * 4^levels triangles.
inline TriangleMesh Sphere(int levels) {
  const double t = (1.0 + std::sqrt(5.0)) / 2.0;
  TriangleMesh mesh;
  mesh.vertices = {{-1, t, 0}, {1, t, 0}, {-1, -t, 0}, {1, -t, 0}, {0, -1, t}, {0, 1, t},
                   {0, -1, -t}, {0, 1, -t}, {t, 0, -1}, {t, 0, 1}, {-t, 0, -1}, {-t, 0, 1}};
  for (Vector3d& v : mesh.vertices) v.normalize();
  mesh.triangles = {{0, 11, 5}, {0, 5, 1}, {0, 1, 7}, {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                    {11, 10, 2}, {10, 7, 6}, {7, 1, 8}, {3, 9, 4}, {3, 4, 2}, {3, 2, 6}, {3, 6, 8},
                    {3, 8, 9}, {4, 9, 5}, {2, 4, 11}, {6, 2, 10}, {8, 6, 7}, {9, 8, 1}};
  for (int level = 0; level < levels; ++level) {
    std::map<std::pair<int, int>, int> middle;
    const auto between = [&](int a, int b) {
      const auto [at, fresh] = middle.try_emplace(std::minmax(a, b), static_cast<int>(mesh.vertices.size()));
      if (fresh) mesh.vertices.push_back((mesh.vertices[a] + mesh.vertices[b]).normalized());
      return at->second;
    };
    std::vector<TriangleMesh::Triangle> finer;
    for (const auto& [a, b, c] : mesh.triangles) {
      const int ab = between(a, b), bc = between(b, c), ca = between(c, a);
      finer.insert(finer.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
    }
    mesh.triangles = std::move(finer);
  }
  return mesh;
}

// The sphere stretched to half axes a, b, c.
inline TriangleMesh Ellipsoid(int levels, double a, double b, double c) {
  TriangleMesh mesh = Sphere(levels);
  for (Vector3d& v : mesh.vertices) v = v.cwiseProduct(Vector3d(a, b, c));
  return mesh;
}

// The cube [0, 1]^3, each face cut into n by n squares of two triangles. grading > 1 crowds the cuts towards the edges:
// u -> u^grading on either half.
inline TriangleMesh Cube(int n, double grading = 1.0) {
  const auto graded = [&](int i) {
    const double u = static_cast<double>(i) / n;
    return u <= 0.5 ? 0.5 * std::pow(2.0 * u, grading) : 1.0 - 0.5 * std::pow(2.0 * (1.0 - u), grading);
  };
  TriangleMesh mesh;
  std::map<std::array<int, 3>, int> known;
  const auto vertex = [&](std::array<int, 3> at) {
    const auto [found, fresh] = known.try_emplace(at, static_cast<int>(mesh.vertices.size()));
    if (fresh) mesh.vertices.emplace_back(graded(at[0]), graded(at[1]), graded(at[2]));
    return found->second;
  };
  for (int axis = 0; axis < 3; ++axis) {
    for (int side : {0, n}) {
      for (int i = 0; i < n; ++i) {
        for (int j = 0; j < n; ++j) {
          const auto corner = [&](int di, int dj) {
            std::array<int, 3> at{};
            at[axis] = side, at[(axis + 1) % 3] = i + di, at[(axis + 2) % 3] = j + dj;
            return vertex(at);
          };
          const int a = corner(0, 0), b = corner(1, 0), c = corner(1, 1), d = corner(0, 1);
          if (side == n) {
            mesh.triangles.insert(mesh.triangles.end(), {{a, b, c}, {a, c, d}});
          } else {
            mesh.triangles.insert(mesh.triangles.end(), {{a, c, b}, {a, d, c}});
          }
        }
      }
    }
  }
  return mesh;
}

// A torus about z.
inline TriangleMesh Torus(double major, double minor, int around, int across) {
  return ClosedGrid(around, across, [&](int i, int j) -> Vector3d {
    const double u = 2.0 * kPi * i / around, v = 2.0 * kPi * j / across, r = major + minor * std::cos(v);
    return {r * std::cos(u), r * std::sin(u), minor * std::sin(v)};
  });
}

// The outside of two unit spheres that meet at right angles (distance sqrt 2), rings along z.
inline TriangleMesh Peanut(int rings_a_lobe) {
  // The profile runs over one sphere from its pole to the seam and over the other to its pole.
  const double pole_to_seam = 0.75 * kPi, centre = std::numbers::sqrt2 / 2.0;
  const int rings = 2 * rings_a_lobe, columns = std::max(6, static_cast<int>(std::lround(2.0 * kPi * rings_a_lobe / pole_to_seam)));
  TriangleMesh mesh;
  mesh.vertices.emplace_back(0, 0, -1.0 - centre);
  for (int ring = 1; ring < rings; ++ring) {
    const bool upper = ring > rings_a_lobe;
    const double t = pole_to_seam * (upper ? rings - ring : ring) / rings_a_lobe;
    const double z = -centre - std::cos(t), radius = std::sin(t);
    for (int j = 0; j < columns; ++j) {
      const double u = 2.0 * kPi * (j + 0.5 * (ring % 2)) / columns;
      mesh.vertices.emplace_back(radius * std::cos(u), radius * std::sin(u), upper ? -z : z);
    }
  }
  mesh.vertices.emplace_back(0, 0, 1.0 + centre);
  const auto at = [&](int ring, int j) { return 1 + (ring - 1) * columns + (j + columns) % columns; };
  const int last = static_cast<int>(mesh.vertices.size()) - 1;
  for (int j = 0; j < columns; ++j) {
    mesh.triangles.push_back({0, at(1, j + 1), at(1, j)});
    mesh.triangles.push_back({last, at(rings - 1, j), at(rings - 1, j + 1)});
    for (int ring = 1; ring + 1 < rings; ++ring) {
      const int shift = ring % 2;  // odd rings are turned by half a step
      mesh.triangles.push_back({at(ring, j), at(ring, j + 1), at(ring + 1, j + shift)});
      mesh.triangles.push_back({at(ring + 1, j), at(ring, j + 1 - shift), at(ring + 1, j + 1)});
    }
  }
  return mesh;
}

inline TriangleMesh Merged(const TriangleMesh& a, const TriangleMesh& b) {
  TriangleMesh mesh = a;
  const int offset = static_cast<int>(a.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), b.vertices.begin(), b.vertices.end());
  for (const auto& [i, j, k] : b.triangles) mesh.triangles.push_back({i + offset, j + offset, k + offset});
  return mesh;
}

// Its exact density for unit charge at p on the surface (image charges 1, 1 and -1/sqrt 2).
inline double PeanutDensity(const Vector3d& p) {
  const double centre = std::numbers::sqrt2 / 2.0;
  const auto field = [&](double z, double q) -> Vector3d {
    const Vector3d from = p - Vector3d(0, 0, z);
    return q * from / std::pow(from.norm(), 3);
  };
  const Vector3d sum = field(centre, 1.0) + field(-centre, 1.0) + field(0.0, -centre);
  return sum.norm() / (4.0 * kPi * kPeanutCapacitance);
}

// The exact density of an ellipsoid for unit charge.
inline double EllipsoidDensity(const Vector3d& p, double a, double b, double c) {
  const double h = std::sqrt(p.x() * p.x() / std::pow(a, 4) + p.y() * p.y() / std::pow(b, 4) + p.z() * p.z() / std::pow(c, 4));
  return 1.0 / (4.0 * kPi * a * b * c * h);
}

// Its capacitance, 1/R_F(a^2, b^2, c^2), by the duplication theorem (DLMF 19.36.1).
inline double EllipsoidCapacitance(double a, double b, double c) {
  double x = a * a, y = b * b, z = c * c;
  for (int i = 0; i < 60; ++i) {
    const double lambda = std::sqrt(x * y) + std::sqrt(y * z) + std::sqrt(z * x);
    x = (x + lambda) / 4.0, y = (y + lambda) / 4.0, z = (z + lambda) / 4.0;
  }
  return std::sqrt((x + y + z) / 3.0);
}

// The root of the mean over the area of (density / exact - 1)^2.
inline double RelativeRms(const TriangleMesh& mesh, const std::vector<double>& density, const std::vector<double>& exact) {
  const std::vector<double> areas = TriangleAreas(mesh);
  double squares = 0.0, area = 0.0;
  for (std::size_t i = 0; i < areas.size(); ++i) {
    squares += areas[i] * (density[i] / exact[i] - 1.0) * (density[i] / exact[i] - 1.0);
    area += areas[i];
  }
  return std::sqrt(squares / area);
}

}  // namespace geond::shapes
