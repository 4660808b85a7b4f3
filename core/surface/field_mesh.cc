// SPDX-License-Identifier: Apache-2.0
#include "core/surface/field_mesh.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "core/base/parallel.h"
#include "core/surface/triangle_tree.h"

namespace geond {

double VoxelSize(double pitch, const Eigen::AlignedBox3d& box, const TessellateOptions& options) {
  const double extent = box.sizes().maxCoeff();
  // About the edge of even triangles on a box of this size, if no length was asked for.
  const Eigen::Vector3d s = box.sizes();
  const double area = 1.6 * (s.x() * s.y() + s.y() * s.z() + s.z() * s.x());
  const double edge = options.edge_length > 0.0 ? options.edge_length
                                                : std::sqrt(4.0 * area / (std::numbers::sqrt3 * std::max(4, options.triangles)));
  return std::clamp(std::min(edge / 1.5, extent / 80.0), 1.2 * pitch, std::max(1.2 * pitch, extent / 20.0));
}

void CutByTable(SignedGrid& grid) {
  for (int k = 0; k < grid.size[2]; ++k) {
    const double z = grid.node(0, 0, k).z();
    if (z > 0.5 * grid.step) break;
    for (std::size_t node = grid.index(0, 0, k); node < grid.index(0, 0, k) + static_cast<std::size_t>(grid.size[0]) * grid.size[1]; ++node) {
      grid.value[node] = std::max(grid.value[node], static_cast<float>(std::abs(z) < 0.5 * grid.step ? 0.0 : -z));
    }
  }
}

TriangleMesh LargeComponents(const TriangleMesh& mesh) {
  const int n = static_cast<int>(mesh.triangles.size());
  std::vector<int> parent(mesh.vertices.size());
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&](int i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  for (const auto& [a, b, c] : mesh.triangles) {
    parent[root(b)] = root(a);
    parent[root(c)] = root(a);
  }
  std::vector<double> volume(mesh.vertices.size(), 0.0);
  for (const auto& [a, b, c] : mesh.triangles) {
    volume[root(a)] += mesh.vertices[a].dot(mesh.vertices[b].cross(mesh.vertices[c])) / 6.0;
  }
  const double largest = volume.empty() ? 0.0 : *std::max_element(volume.begin(), volume.end());
  TriangleMesh result;
  std::vector<int> index(mesh.vertices.size(), -1);
  for (int t = 0; t < n; ++t) {
    if (!(volume[root(mesh.triangles[t][0])] > 0.01 * largest)) continue;
    TriangleMesh::Triangle triangle = mesh.triangles[t];
    for (int& v : triangle) {
      if (index[v] < 0) {
        index[v] = static_cast<int>(result.vertices.size());
        result.vertices.push_back(mesh.vertices[v]);
      }
      v = index[v];
    }
    result.triangles.push_back(triangle);
    if (!mesh.triangle_seen.empty()) result.triangle_seen.push_back(mesh.triangle_seen[t]);
  }
  return result;
}

SurfaceProjection FieldProjection(const SignedGrid& grid, bool closed_by_table) {
  return [&grid, closed_by_table](const Eigen::Vector3d& p, const Eigen::Vector3d& normal) -> Eigen::Vector3d {
    // Near the table the grid's own values bend towards the plane: the field is read a step above it.
    const double lowest = closed_by_table ? 1.001 * grid.step : -1e300;
    if (closed_by_table && p.z() < 0.35 * grid.step && normal.z() < -0.5) return {p.x(), p.y(), 0.0};
    Eigen::Vector3d q = p;
    for (int i = 0; i < 4; ++i) {
      Eigen::Vector3d gradient;
      const Eigen::Vector3d at(q.x(), q.y(), std::max(q.z(), lowest));
      const double value = grid.Sample(at, &gradient);
      const double squared = gradient.squaredNorm();
      if (squared < 0.04) break;
      Eigen::Vector3d step = -value / squared * gradient;
      if (closed_by_table && at.z() != q.z()) step.z() = 0.0;
      const double length = step.norm();
      if (length > grid.step) step *= grid.step / length;
      q += step;
      if (closed_by_table) q.z() = std::max(q.z(), 0.0);
      if (length < 1e-4 * grid.step) break;
    }
    return q;
  };
}

void MarkSeen(TriangleMesh& mesh, const std::vector<Eigen::Vector3d>& points, double reach, int threads) {
  std::vector<std::array<int, 3>> degenerate(points.size());
  for (int i = 0; i < static_cast<int>(points.size()); ++i) degenerate[i] = {i, i, i};
  const TriangleTree tree(points, degenerate);
  mesh.triangle_seen.resize(mesh.triangles.size());
  ParallelFor(static_cast<std::ptrdiff_t>(mesh.triangles.size()), threads, 256, [&](std::ptrdiff_t t) {
    mesh.triangle_seen[t] = tree.Nearest(TriangleCentroid(mesh, static_cast<int>(t)), reach).triangle >= 0;
  });
}

}  // namespace geond
