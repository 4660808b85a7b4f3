// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "core/geon/geon.h"
#include "core/geon/geon_mesh.h"
#include "core/geon/shape.h"

namespace geond {

// Systematic by area over the triangles of a fine mesh, places within a triangle by a low-discrepancy sequence, each carried
// along its ray to the exact surface.
PointCloud SampleGeon(const Geon& geon, int count) {
  if (count < 1) throw std::invalid_argument("the number of samples of a geon must be positive");
  CheckGeon(geon);
  const double extent = geon.size.norm();
  const RegularMesh mesh = MeshRegularPrimitive(geon, std::clamp(2.0 / std::sqrt(count), 0.02, 0.25) * extent);
  std::vector<double> up_to;
  double total = 0.0;
  for (const auto& t : mesh.triangles) {
    const Eigen::Vector3d a = Deform(geon, mesh.vertices[t[0]]), b = Deform(geon, mesh.vertices[t[1]]),
                          c = Deform(geon, mesh.vertices[t[2]]);
    total += 0.5 * (b - a).cross(c - a).norm();
    up_to.push_back(total);
  }
  // Steps of the plastic number's sequence: even coverage of the unit square.
  constexpr double kPlastic = 1.32471795724474602596;
  PointCloud cloud;
  cloud.points.reserve(count);
  cloud.normals.reserve(count);
  std::size_t triangle = 0;
  for (int i = 0; i < count; ++i) {
    const double at = total * (i + 0.5) / count;
    while (triangle + 1 < up_to.size() && up_to[triangle] < at) ++triangle;
    double u = std::fmod(0.5 + i / kPlastic, 1.0), v = std::fmod(0.5 + i / (kPlastic * kPlastic), 1.0);
    if (u + v > 1.0) {
      u = 1.0 - u;
      v = 1.0 - v;
    }
    const auto& t = mesh.triangles[triangle];
    const Eigen::Vector3d p = (1.0 - u - v) * mesh.vertices[t[0]] + u * mesh.vertices[t[1]] + v * mesh.vertices[t[2]];
    const Eigen::Vector3d x = p / Gauge(geon, p);
    cloud.points.push_back(geon.X_TG * Deform(geon, x));
    cloud.normals.push_back(geon.X_TG.Rotate(SurfaceNormal(geon, x)));
  }
  return cloud;
}

}  // namespace geond
