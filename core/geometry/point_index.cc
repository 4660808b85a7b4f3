// SPDX-License-Identifier: Apache-2.0
#include "core/geometry/point_index.h"

#include <algorithm>

#include <nanoflann.hpp>

namespace geond {
namespace {

struct Adaptor {
  const std::vector<Eigen::Vector3d>& points;
  std::size_t kdtree_get_point_count() const { return points.size(); }
  double kdtree_get_pt(std::size_t i, std::size_t axis) const { return points[i][static_cast<Eigen::Index>(axis)]; }
  template <typename Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};

using KdTree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, Adaptor>, Adaptor, 3, int>;

}  // namespace

struct PointIndex::Tree {
  Adaptor adaptor;
  KdTree tree;
  explicit Tree(const std::vector<Eigen::Vector3d>& points) : adaptor{points}, tree(3, adaptor, {16}) { tree.buildIndex(); }
};

PointIndex::PointIndex(const std::vector<Eigen::Vector3d>& points) : tree_(std::make_unique<Tree>(points)) {}
PointIndex::~PointIndex() = default;

PointIndex::Neighbors PointIndex::Nearest(const Eigen::Vector3d& p, int k) const {
  std::vector<int> indices(k);
  std::vector<double> squared(k);
  const std::size_t n = tree_->tree.knnSearch(p.data(), k, indices.data(), squared.data());
  Neighbors neighbors;
  neighbors.reserve(n);
  for (std::size_t i = 0; i < n; ++i) neighbors.emplace_back(indices[i], squared[i]);
  return neighbors;
}

PointIndex::Neighbors PointIndex::Within(const Eigen::Vector3d& p, double radius) const {
  std::vector<std::pair<int, double>> found;
  nanoflann::SearchParams parameters;
  parameters.sorted = false;
  tree_->tree.radiusSearch(p.data(), radius * radius, found, parameters);
  // In an order of their own: what is summed over them does not depend on the tree.
  std::sort(found.begin(), found.end(), [](const auto& a, const auto& b) {
    return a.second != b.second ? a.second < b.second : a.first < b.first;
  });
  return found;
}

}  // namespace geond
