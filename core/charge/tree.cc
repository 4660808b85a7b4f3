// SPDX-License-Identifier: Apache-2.0
#include "core/charge/tree.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/parallel.h"

namespace geond::charge {
namespace {

constexpr int kDeepest = 20;  // levels below the root: 3 bits each of a 64-bit key

// The bits of a coordinate, two places between each.
std::uint64_t SpreadBits(std::uint64_t v) {
  v &= 0x1fffff;
  v = (v | v << 32) & 0x1f00000000ffff;
  v = (v | v << 16) & 0x1f0000ff0000ff;
  v = (v | v << 8) & 0x100f00f00f00f00f;
  v = (v | v << 4) & 0x10c30c30c30c30c3;
  v = (v | v << 2) & 0x1249249249249249;
  return v;
}

using Keyed = std::pair<std::uint64_t, int>;

// Sorted by key, then index: eight buckets by the first digits are sorted side by side.
void SortKeys(std::vector<Keyed>& keys, int threads) {
  constexpr int kBucketBits = 6;
  std::array<std::ptrdiff_t, (1 << kBucketBits) + 1> begin{};
  const auto bucket = [](const Keyed& key) { return key.first >> (3 * kDeepest - kBucketBits); };
  for (const Keyed& key : keys) ++begin[bucket(key) + 1];
  for (std::size_t b = 1; b < begin.size(); ++b) begin[b] += begin[b - 1];
  std::vector<Keyed> placed(keys.size());
  auto next = begin;
  for (const Keyed& key : keys) placed[next[bucket(key)]++] = key;
  ParallelFor(1 << kBucketBits, keys.size() < 20000 ? 1 : threads, 1, [&](std::ptrdiff_t b) {
    std::sort(placed.begin() + begin[b], placed.begin() + begin[b + 1]);
  });
  keys.swap(placed);
}

}  // namespace

Tree BuildTree(const TriangleMesh& mesh, const Panels& panels, int leaf_capacity, int threads) {
  const int n = static_cast<int>(panels.size());
  const int used_threads = n < 20000 ? 1 : threads;
  Eigen::Vector3d low(panels.x[0], panels.y[0], panels.z[0]), high = low;
  for (int i = 0; i < n; ++i) {
    const Eigen::Vector3d p(panels.x[i], panels.y[i], panels.z[i]);
    low = low.cwiseMin(p), high = high.cwiseMax(p);
  }
  const Eigen::Vector3d centre = (low + high) / 2.0;
  const double half_side = 0.5001 * (high - low).maxCoeff() + 1e-300;
  const Eigen::Vector3d corner = centre.array() - half_side;

  std::vector<Keyed> keys(n);
  const double per_side = std::ldexp(1.0, kDeepest) / (2.0 * half_side);
  ParallelFor(n, used_threads, 4096, [&](std::ptrdiff_t i) {
    const auto digit = [&](double x, double from) {
      return SpreadBits(static_cast<std::uint64_t>(std::clamp((x - from) * per_side, 0.0, std::ldexp(1.0, kDeepest) - 1.0)));
    };
    keys[i] = {digit(panels.x[i], corner.x()) | digit(panels.y[i], corner.y()) << 1 | digit(panels.z[i], corner.z()) << 2,
               static_cast<int>(i)};
  });
  SortKeys(keys, threads);

  Tree tree;
  tree.order.resize(n);
  for (int i = 0; i < n; ++i) tree.order[i] = keys[i].second;
  Cell root;
  root.end = n;
  root.centre = centre;
  root.half_side = half_side;
  tree.cells.push_back(root);
  tree.level_begin = {0, 1};
  for (int level = 0; level < kDeepest; ++level) {
    for (int c = tree.level_begin[level]; c < tree.level_begin[level + 1]; ++c) {
      if (tree.cells[c].count() <= leaf_capacity) continue;
      const Cell parent = tree.cells[c];
      tree.cells[c].first_child = static_cast<int>(tree.cells.size());
      const int shift = 3 * (kDeepest - 1 - level);
      for (int begin = parent.begin; begin < parent.end;) {
        const auto digit = keys[begin].first >> shift & 7;
        const auto stop = std::partition_point(keys.begin() + begin, keys.begin() + parent.end,
                                               [&](const Keyed& key) { return (key.first >> shift & 7) <= digit; });
        Cell child;
        child.begin = begin;
        child.end = static_cast<int>(stop - keys.begin());
        child.parent = c;
        child.level = level + 1;
        child.half_side = parent.half_side / 2.0;
        for (int axis = 0; axis < 3; ++axis) {
          const int upper = static_cast<int>(digit >> axis & 1);
          child.corner[axis] = 2 * parent.corner[axis] + upper;
          child.centre[axis] = parent.centre[axis] + (upper ? child.half_side : -child.half_side);
        }
        tree.cells.push_back(child);
        begin = child.end;
      }
      tree.cells[c].child_count = static_cast<int>(tree.cells.size()) - tree.cells[c].first_child;
    }
    if (static_cast<int>(tree.cells.size()) == tree.level_begin.back()) break;
    tree.level_begin.push_back(static_cast<int>(tree.cells.size()));
  }

  // A cell's reach: measured over its triangles in a leaf, bounded by its children's above.
  for (int level = static_cast<int>(tree.level_begin.size()) - 2; level >= 0; --level) {
    const int first = tree.level_begin[level];
    ParallelFor(tree.level_begin[level + 1] - first, used_threads, 64, [&](std::ptrdiff_t c) {
      Cell& cell = tree.cells[first + c];
      for (int child = cell.first_child; child < cell.first_child + cell.child_count; ++child) {
        const Cell& inner = tree.cells[child];
        const double away = (inner.centre - cell.centre).norm();
        cell.centroid_radius = std::max(cell.centroid_radius, away + inner.centroid_radius);
        cell.triangle_radius = std::max(cell.triangle_radius, away + inner.triangle_radius);
      }
      // Few enough to look at one by one: tighter than the bound.
      if (!cell.is_leaf() && cell.count() > 8 * leaf_capacity) return;
      double centroids = 0.0, triangles = 0.0;
      for (int i = cell.begin; i < cell.end; ++i) {
        const int t = tree.order[i];
        centroids = std::max(centroids, (Eigen::Vector3d(panels.x[t], panels.y[t], panels.z[t]) - cell.centre).squaredNorm());
        for (int v : mesh.triangles[t]) triangles = std::max(triangles, (mesh.vertices[v] - cell.centre).squaredNorm());
      }
      cell.centroid_radius = std::sqrt(centroids);
      cell.triangle_radius = std::sqrt(triangles);
    });
  }
  for (std::size_t c = 0; c < tree.cells.size(); ++c) {
    if (tree.cells[c].is_leaf()) tree.leaves.push_back(static_cast<int>(c));
  }
  std::sort(tree.leaves.begin(), tree.leaves.end(),
            [&](int a, int b) { return tree.cells[a].begin < tree.cells[b].begin; });
  return tree;
}

}  // namespace geond::charge
