// SPDX-License-Identifier: Apache-2.0
#include "core/surface/close_mesh.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>
#include <string>
#include <tuple>
#include <vector>

#include "core/base/parallel.h"
#include "core/base/progress.h"
#include "core/surface/field_mesh.h"
#include "core/surface/triangle_tree.h"
#include "core/surface/winding_field.h"
#include "core/surface/winding_number.h"

namespace geond {
namespace {

// The mesh with vertices at the same place made one, without triangles that repeat a vertex or another triangle.
TriangleMesh Welded(const TriangleMesh& mesh) {
  std::vector<int> order(mesh.vertices.size()), index(mesh.vertices.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = static_cast<int>(i);
  const auto key = [&](int i) { return std::make_tuple(mesh.vertices[i].x(), mesh.vertices[i].y(), mesh.vertices[i].z()); };
  std::sort(order.begin(), order.end(), [&](int i, int j) { return std::make_tuple(key(i), i) < std::make_tuple(key(j), j); });
  for (std::size_t i = 0; i < order.size(); ++i) {
    index[order[i]] = i > 0 && key(order[i]) == key(order[i - 1]) ? index[order[i - 1]] : order[i];
  }
  TriangleMesh result{mesh.vertices, {}, {}};
  for (TriangleMesh::Triangle triangle : mesh.triangles) {
    for (int& v : triangle) v = index[v];
    if (triangle[0] != triangle[1] && triangle[1] != triangle[2] && triangle[2] != triangle[0]) result.triangles.push_back(triangle);
  }
  std::set<TriangleMesh::Triangle> known;
  std::erase_if(result.triangles, [&](TriangleMesh::Triangle triangle) {
    std::sort(triangle.begin(), triangle.end());
    return !known.insert(triangle).second;
  });
  return result;
}

// Triangles joined over edges are turned alike, each patch the way most of its area was turned before.
void TurnAlike(TriangleMesh& mesh) {
  const std::vector<std::array<int, 3>> neighbors = TriangleNeighbors(mesh);
  const std::vector<double> areas = TriangleAreas(mesh);
  const int n = static_cast<int>(mesh.triangles.size());
  std::vector<signed char> turned(n, -1);
  for (int seed = 0; seed < n; ++seed) {
    if (turned[seed] >= 0) continue;
    std::vector<int> patch{seed};
    turned[seed] = 0;
    double area[2] = {0.0, 0.0};
    for (std::size_t next = 0; next < patch.size(); ++next) {
      const int t = patch[next];
      area[static_cast<int>(turned[t])] += areas[t];
      for (int side = 0; side < 3; ++side) {
        const int other = neighbors[t][side];
        if (other < 0 || turned[other] >= 0) continue;
        const int a = mesh.triangles[t][side], b = mesh.triangles[t][(side + 1) % 3];
        bool same_way = false, is_pair = false;
        for (int k = 0; k < 3; ++k) {
          const int c = mesh.triangles[other][k], d = mesh.triangles[other][(k + 1) % 3];
          if (neighbors[other][k] != t) continue;  // more than two triangles meet here: nothing follows
          if (c == a && d == b) same_way = is_pair = true;
          if (c == b && d == a) is_pair = true;
        }
        if (!is_pair) continue;
        turned[other] = same_way ? 1 - turned[t] : turned[t];
        patch.push_back(other);
      }
    }
    const signed char against = area[1] > area[0] ? 0 : 1;
    for (int t : patch) {
      if (turned[t] == against) std::swap(mesh.triangles[t][1], mesh.triangles[t][2]);
    }
  }
}

}  // namespace

TriangleMesh CloseMesh(const TriangleMesh& input, const TessellateOptions& options, std::stop_token stop) {
  CheckMesh(input);
  TriangleMesh mesh = Welded(input);
  if (mesh.triangles.size() < 4) throw std::invalid_argument("CloseMesh: fewer than four triangles enclose nothing");
  TurnAlike(mesh);
  if (Volume(mesh) < 0.0) {
    for (TriangleMesh::Triangle& triangle : mesh.triangles) std::swap(triangle[1], triangle[2]);
  }
  Eigen::AlignedBox3d box;
  for (const auto& triangle : mesh.triangles) {
    for (int v : triangle) box.extend(mesh.vertices[v]);
  }
  const double voxel = options.voxel_size > 0.0 ? options.voxel_size : VoxelSize(box.diagonal().norm() / 400.0, box, options);
  const TriangleTree tree(mesh.vertices, mesh.triangles);
  const WindingNumber winding(mesh);
  const auto distance = [&](const Eigen::Vector3d& p, double limit) { return std::sqrt(tree.Nearest(p, limit).squared_distance); };
  const double reach = 2.0 * voxel;
  const FieldSource source{distance, [&](const Eigen::Vector3d& p, double w) { return std::clamp(1.0 - 2.0 * w, -1.0, 1.0) * distance(p, reach); }};
  const Eigen::AlignedBox3d bounds(box.min().array() - 2 * voxel, box.max().array() + 2 * voxel);
  const SignedGrid grid = WindingField(SignedGrid(bounds, voxel, 0.0f), winding, source, reach, options.threads, stop);

  const TriangleMesh raw = LargeComponents(MarchingTetrahedra(grid));
  if (raw.empty()) {
    throw std::invalid_argument("the mesh encloses nothing: its triangles bound no volume that could be closed");
  }
  const SurfaceProjection on_field = FieldProjection(grid, false);
  const auto project = [&](const Eigen::Vector3d& p, const Eigen::Vector3d& normal) -> Eigen::Vector3d {
    const TriangleTree::Hit hit = tree.Nearest(p, 1.5 * voxel);
    // Where the field's level and the triangles part, one stands inside the solid or there is a hole.
    if (hit.triangle < 0 || std::abs(grid.Sample(hit.point)) > 0.75 * voxel) return on_field(p, normal);
    return hit.point;
  };
  TriangleMesh result = RemeshOnto(raw, project,
                                   {.triangles = options.triangles, .edge_length = options.edge_length, .threads = options.threads}, stop);
  result.triangle_seen.resize(result.triangles.size());
  ParallelFor(static_cast<std::ptrdiff_t>(result.triangles.size()), options.threads, 256, [&](std::ptrdiff_t t) {
    result.triangle_seen[t] = tree.Nearest(TriangleCentroid(result, static_cast<int>(t)), 1.5 * voxel).triangle >= 0;
  });
  return result;
}

}  // namespace geond
