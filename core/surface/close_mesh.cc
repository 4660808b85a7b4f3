// SPDX-License-Identifier: Apache-2.0
#include "core/surface/close_mesh.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
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

// One way to close: voxels of this size; `thicken`: sheets get walls of twice that much.
struct Attempt {
  double voxel;
  double thicken;
};

struct Closed {
  TriangleMesh mesh;
  SignedGrid grid;
  double lost = 1.0;  // share of the input's area that the result misses by far
};

Closed Close(const TriangleMesh& mesh, const TriangleTree& tree, const WindingNumber& winding, const Eigen::AlignedBox3d& box,
             const Attempt& attempt, int threads, const std::stop_token& stop) {
  const double voxel = attempt.voxel, reach = 2.0 * voxel;
  const auto value = [&](const Eigen::Vector3d& p, const std::function<double()>& w) -> std::optional<double> {
    const TriangleTree::Hit hit = tree.Nearest(p, reach);
    if (hit.triangle < 0) return std::nullopt;
    const double distance = std::sqrt(hit.squared_distance);
    const double turned = std::clamp(1.0 - 2.0 * w(), -1.0, 1.0) * distance;
    return attempt.thicken > 0.0 ? std::min(turned, distance - attempt.thicken) : turned;
  };
  const auto distance = [&](const Eigen::Vector3d& p, double limit) { return std::sqrt(tree.Nearest(p, limit).squared_distance); };
  const Eigen::AlignedBox3d bounds(box.min().array() - 3 * voxel, box.max().array() + 3 * voxel);
  Closed closed;
  closed.grid = WindingField(SignedGrid(bounds, voxel, 0.0f), winding, {distance, value, reach}, threads, stop);
  closed.mesh = LargeComponents(MarchingTetrahedra(closed.grid));
  if (closed.mesh.empty()) return closed;
  const TriangleTree result(closed.mesh.vertices, closed.mesh.triangles);
  double lost = 0.0, total = 0.0;
  for (int t = 0; t < static_cast<int>(mesh.triangles.size()); ++t) {
    const double area = TriangleAreaVector(mesh, t).norm();
    const Eigen::Vector3d center = TriangleCentroid(mesh, t);
    total += area;
    if (result.Nearest(center, 1.5 * voxel + attempt.thicken).triangle >= 0) continue;
    // What has the solid on both sides is no surface of it.
    const Eigen::Vector3d ahead = center + 0.5 * voxel * TriangleAreaVector(mesh, t).stableNormalized();
    if (winding.At(ahead) < 0.6) lost += area;
  }
  closed.lost = total > 0.0 ? lost / total : 1.0;
  return closed;
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
  // Walls thinner than the voxels fall to pieces: then smaller voxels, and last of all thicker walls.
  Closed best;
  Attempt attempt{voxel, 0.0};
  int best_genus = 0;
  for (const Attempt& next : {Attempt{voxel, 0.0}, Attempt{voxel / 1.6, 0.0}, Attempt{voxel / 1.6, 0.55 * voxel}}) {
    Closed closed = Close(mesh, tree, winding, box, next, options.threads, stop);
    if (closed.mesh.empty()) continue;
    const int genus = Topology(closed.mesh).genus;
    const auto badness = [](const Closed& c, int g) { return c.lost + 0.01 * g; };
    if (best.mesh.empty() || badness(closed, genus) < badness(best, best_genus) - 0.02) {
      best = std::move(closed);
      best_genus = genus;
      attempt = next;
    }
    if (best.lost < 0.02 && best_genus <= 3) break;
  }
  if (best.mesh.empty() || best.lost > 0.3) {
    throw std::invalid_argument("the mesh encloses nothing: its triangles bound no volume that could be closed");
  }
  const SignedGrid& grid = best.grid;
  const TriangleMesh& raw = best.mesh;
  const SurfaceProjection on_field = FieldProjection(grid, false);
  const auto project = [&](const Eigen::Vector3d& p, const Eigen::Vector3d& normal) -> Eigen::Vector3d {
    if (attempt.thicken > 0.0) return on_field(p, normal);
    const TriangleTree::Hit hit = tree.Nearest(p, 1.5 * attempt.voxel);
    // Where the field's level and the triangles part, one stands inside the solid or there is a hole.
    if (hit.triangle < 0 || std::abs(grid.Sample(hit.point)) > 0.75 * attempt.voxel) return on_field(p, normal);
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
