// SPDX-License-Identifier: Apache-2.0
#include "core/geometry/sample_mesh.h"

#include <cmath>
#include <stdexcept>

namespace geond {

// Points sit at equal steps of the cumulated area; inside a triangle they follow the R2 sequence (the plane's golden
// ratio), folded on the triangle.
PointCloud SampleMesh(const TriangleMesh& mesh, int count, bool only_seen) {
  std::vector<double> areas = TriangleAreas(mesh);
  if (only_seen && mesh.triangle_seen.size() == areas.size()) {
    for (std::size_t t = 0; t < areas.size(); ++t) areas[t] *= mesh.triangle_seen[t];
  }
  double total = 0.0;
  for (double area : areas) total += area;
  if (!(total > 0.0) || count < 1) throw std::invalid_argument("SampleMesh: the mesh has no area to sample");

  constexpr double kPlastic = 1.32471795724474602596;
  PointCloud cloud;
  cloud.points.reserve(count);
  cloud.normals.reserve(count);
  double reached = 0.0;
  int i = 0;
  for (std::size_t t = 0; t < areas.size(); ++t) {
    reached += areas[t];
    for (; i < count && (i + 0.5) * total <= reached * count; ++i) {
      double u = std::fmod(i / kPlastic, 1.0), v = std::fmod(i / (kPlastic * kPlastic), 1.0);
      if (u + v > 1.0) u = 1.0 - u, v = 1.0 - v;
      const auto& [a, b, c] = mesh.triangles[t];
      cloud.points.push_back((1.0 - u - v) * mesh.vertices[a] + u * mesh.vertices[b] + v * mesh.vertices[c]);
      cloud.normals.push_back(TriangleAreaVector(mesh, static_cast<int>(t)).stableNormalized());
    }
  }
  return cloud;
}

}  // namespace geond
