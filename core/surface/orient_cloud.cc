// SPDX-License-Identifier: Apache-2.0
#include "core/surface/orient_cloud.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>
#include <vector>

#include "core/base/parallel.h"
#include "core/geometry/point_index.h"

namespace geond {
namespace {

constexpr int kNeighbors = 10;

struct Link {
  float bend;  // 1 - |cosine| of the two normals, and a little for the distance
  int a, b;
};

std::vector<std::vector<int>> NeighborLists(const PointCloud& cloud, int threads) {
  const PointIndex index(cloud.points);
  std::vector<std::vector<int>> lists(cloud.size());
  ParallelFor(static_cast<std::ptrdiff_t>(cloud.size()), threads, 256, [&](std::ptrdiff_t i) {
    for (const auto& [j, squared] : index.Nearest(cloud.points[i], kNeighbors + 1)) {
      if (j != i) lists[i].push_back(j);
    }
  });
  return lists;
}

int Root(std::vector<int>& parent, int i) {
  while (parent[i] != i) i = parent[i] = parent[parent[i]];
  return i;
}

}  // namespace

bool NormalsAgree(const PointCloud& cloud, int threads) {
  if (!cloud.has_normals()) return false;
  const auto lists = NeighborLists(cloud, threads);
  std::size_t against = 0, total = 0;
  for (std::size_t i = 0; i < lists.size(); ++i) {
    if (!cloud.normals[i].allFinite() || cloud.normals[i].squaredNorm() < 0.25) return false;
    for (int j : lists[i]) {
      const double cosine = cloud.normals[i].dot(cloud.normals[j]);
      if (std::abs(cosine) < 0.5) continue;
      ++total;
      against += cosine < 0.0;
    }
  }
  return total > 0 && static_cast<double>(against) < 0.04 * static_cast<double>(total);
}

PointCloud OrientOutward(PointCloud cloud, int threads) {
  const int n = static_cast<int>(cloud.size());
  const auto lists = NeighborLists(cloud, threads);
  std::vector<Link> links;
  for (int i = 0; i < n; ++i) {
    for (int j : lists[i]) {
      if (i > j && std::find(lists[j].begin(), lists[j].end(), i) != lists[j].end()) continue;  // listed from the other end
      const Eigen::Vector3d along = (cloud.points[j] - cloud.points[i]).normalized();
      // Two sheets of a thin wall have parallel normals, but the way from one to the other runs along them.
      const double across = std::max(std::abs(along.dot(cloud.normals[i])), std::abs(along.dot(cloud.normals[j])));
      links.push_back({static_cast<float>(1.0 - std::abs(cloud.normals[i].dot(cloud.normals[j])) + 0.5 * across * across), i, j});
    }
  }
  std::sort(links.begin(), links.end(), [](const Link& l, const Link& r) {
    return std::tie(l.bend, l.a, l.b) < std::tie(r.bend, r.a, r.b);
  });
  std::vector<int> parent(n);
  std::iota(parent.begin(), parent.end(), 0);
  std::vector<std::vector<int>> tree(n);
  for (const Link& link : links) {
    const int a = Root(parent, link.a), b = Root(parent, link.b);
    if (a == b) continue;
    parent[b] = a;
    tree[link.a].push_back(link.b);
    tree[link.b].push_back(link.a);
  }
  std::vector<bool> done(n, false);
  for (int seed = 0; seed < n; ++seed) {
    if (done[seed]) continue;
    std::vector<int> piece{seed};
    done[seed] = true;
    for (std::size_t next = 0; next < piece.size(); ++next) {
      const int i = piece[next];
      for (int j : tree[i]) {
        if (done[j]) continue;
        done[j] = true;
        // Across a sharp turn the normals are reflected rather than compared: on a convex edge and on a concave one the sum
        // of the angles to the way between the points tells the side.
        const Eigen::Vector3d way = cloud.points[j] - cloud.points[i];
        const Eigen::Vector3d mirrored = cloud.normals[i] - 2.0 * cloud.normals[i].dot(way) / std::max(way.squaredNorm(), 1e-30) * way;
        if (mirrored.dot(cloud.normals[j]) < 0.0) cloud.normals[j] = -cloud.normals[j];
        piece.push_back(j);
      }
    }
    double outward = 0.0;
    for (int k = 0; k < 27; ++k) {
      const Eigen::Vector3d direction(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1);
      if (direction.isZero()) continue;
      const int extreme = *std::max_element(piece.begin(), piece.end(), [&](int i, int j) {
        return cloud.points[i].dot(direction) < cloud.points[j].dot(direction);
      });
      outward += cloud.normals[extreme].dot(direction.normalized());
    }
    if (outward < 0.0) {
      for (int i : piece) cloud.normals[i] = -cloud.normals[i];
    }
  }
  return cloud;
}

}  // namespace geond
