// SPDX-License-Identifier: Apache-2.0
#include "core/surface/triangle_tree.h"

#include <algorithm>
#include <numeric>

namespace geond {

// By the Voronoi region of the triangle's corners, sides and inside that p falls into.
Eigen::Vector3d NearestOnTriangle(const Eigen::Vector3d& p, const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                                  const Eigen::Vector3d& c) {
  const Eigen::Vector3d ab = b - a, ac = c - a, ap = p - a;
  const double ab_ap = ab.dot(ap), ac_ap = ac.dot(ap);
  if (ab_ap <= 0.0 && ac_ap <= 0.0) return a;
  const Eigen::Vector3d bp = p - b;
  const double ab_bp = ab.dot(bp), ac_bp = ac.dot(bp);
  if (ab_bp >= 0.0 && ac_bp <= ab_bp) return b;
  const double along_ab = ab_ap * ac_bp - ab_bp * ac_ap;
  if (along_ab <= 0.0 && ab_ap >= 0.0 && ab_bp <= 0.0) return a + ab_ap / (ab_ap - ab_bp) * ab;
  const Eigen::Vector3d cp = p - c;
  const double ab_cp = ab.dot(cp), ac_cp = ac.dot(cp);
  if (ac_cp >= 0.0 && ab_cp <= ac_cp) return c;
  const double along_ac = ab_cp * ac_ap - ab_ap * ac_cp;
  if (along_ac <= 0.0 && ac_ap >= 0.0 && ac_cp <= 0.0) return a + ac_ap / (ac_ap - ac_cp) * ac;
  const double along_bc = ab_bp * ac_cp - ab_cp * ac_bp;
  const double to_c = ac_bp - ab_bp, to_b = ab_cp - ac_cp;
  if (along_bc <= 0.0 && to_c >= 0.0 && to_b >= 0.0) return b + to_c / (to_c + to_b) * (c - b);
  const double sum = along_ab + along_ac + along_bc;
  return a + (along_ac * ab + along_ab * ac) / sum;
}

TriangleTree::TriangleTree(const std::vector<Eigen::Vector3d>& vertices,
                           const std::vector<std::array<int, 3>>& triangles) {
  const int n = static_cast<int>(triangles.size());
  if (n == 0) return;
  std::vector<Eigen::Vector3d> centers(n);
  for (int t = 0; t < n; ++t) {
    centers[t] = (vertices[triangles[t][0]] + vertices[triangles[t][1]] + vertices[triangles[t][2]]) / 3.0;
  }
  ids_.resize(n);
  std::iota(ids_.begin(), ids_.end(), 0);
  corners_.resize(n);
  for (int t = 0; t < n; ++t) {
    corners_[t] = {vertices[triangles[t][0]], vertices[triangles[t][1]], vertices[triangles[t][2]]};
  }
  nodes_.reserve(n);
  Build(0, n, centers);
  const auto unsorted = corners_;
  for (int i = 0; i < n; ++i) corners_[i] = unsorted[ids_[i]];
}

int TriangleTree::Build(int begin, int end, std::vector<Eigen::Vector3d>& centers) {
  constexpr int kLeaf = 4;
  const int index = static_cast<int>(nodes_.size());
  nodes_.emplace_back();
  Eigen::AlignedBox3d box, center_box;
  for (int i = begin; i < end; ++i) {
    for (const Eigen::Vector3d& corner : corners_[ids_[i]]) box.extend(corner);
    center_box.extend(centers[ids_[i]]);
  }
  nodes_[index].box = box;
  nodes_[index].begin = begin;
  nodes_[index].end = end;
  if (end - begin <= kLeaf) return index;
  int axis;
  center_box.sizes().maxCoeff(&axis);
  const int middle = begin + (end - begin) / 2;
  std::nth_element(ids_.begin() + begin, ids_.begin() + middle, ids_.begin() + end, [&](int i, int j) {
    return centers[i][axis] != centers[j][axis] ? centers[i][axis] < centers[j][axis] : i < j;
  });
  Build(begin, middle, centers);
  nodes_[index].right = Build(middle, end, centers);
  return index;
}

TriangleTree::Hit TriangleTree::Nearest(const Eigen::Vector3d& p, double limit) const {
  Hit best;
  best.squared_distance = limit * limit;
  if (empty()) return best;
  struct Entry {
    int node;
    double squared_distance;
  };
  std::array<Entry, 64> stack;
  int depth = 0;
  stack[depth++] = {0, nodes_[0].box.squaredExteriorDistance(p)};
  while (depth > 0) {
    const Entry entry = stack[--depth];
    if (entry.squared_distance > best.squared_distance) continue;
    const Node& node = nodes_[entry.node];
    if (node.right < 0) {
      for (int i = node.begin; i < node.end; ++i) {
        const Eigen::Vector3d q = NearestOnTriangle(p, corners_[i][0], corners_[i][1], corners_[i][2]);
        const double d = (p - q).squaredNorm();
        if (d < best.squared_distance || (d == best.squared_distance && (best.triangle < 0 || ids_[i] < best.triangle))) {
          best = {ids_[i], q, d};
        }
      }
      continue;
    }
    Entry near{entry.node + 1, nodes_[entry.node + 1].box.squaredExteriorDistance(p)};
    Entry far{node.right, nodes_[node.right].box.squaredExteriorDistance(p)};
    if (far.squared_distance < near.squared_distance) std::swap(near, far);
    stack[depth++] = far;
    stack[depth++] = near;
  }
  return best;
}

}  // namespace geond
