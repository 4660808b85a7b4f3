// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include <Eigen/Core>

namespace geond {

// Finds the nearest of a set of points, which must outlive it. Const calls may run on many threads.
class PointIndex {
 public:
  using Neighbors = std::vector<std::pair<int, double>>;  // index and squared distance (m^2)

  explicit PointIndex(const std::vector<Eigen::Vector3d>& points);
  ~PointIndex();

  // The k nearest, nearest first; fewer if there are no more.
  Neighbors Nearest(const Eigen::Vector3d& p, int k) const;
  // All within `radius` (m), nearest first.
  Neighbors Within(const Eigen::Vector3d& p, double radius) const;

 private:
  struct Tree;
  std::unique_ptr<Tree> tree_;
};

}  // namespace geond
