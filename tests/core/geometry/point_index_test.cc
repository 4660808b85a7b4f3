// SPDX-License-Identifier: Apache-2.0
#include "core/geometry/point_index.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

namespace geond {
namespace {

std::vector<Eigen::Vector3d> Scatter(int count) {
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < count; ++i) {
    points.push_back({std::fmod(i * 0.6180339887, 1.0), std::fmod(i * 0.7548776662, 1.0), std::fmod(i * 0.5698402910, 1.0)});
  }
  return points;
}

// Indices and squared distances of all points, nearest first.
PointIndex::Neighbors BruteForce(const std::vector<Eigen::Vector3d>& points, const Eigen::Vector3d& p) {
  PointIndex::Neighbors all;
  for (std::size_t i = 0; i < points.size(); ++i) all.emplace_back(static_cast<int>(i), (points[i] - p).squaredNorm());
  std::sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
  return all;
}

TEST(PointIndex, FindsTheSameAsLookingAtEveryPoint) {
  const std::vector<Eigen::Vector3d> points = Scatter(500);
  const PointIndex index(points);
  for (const Eigen::Vector3d& p : {Eigen::Vector3d(0.5, 0.5, 0.5), Eigen::Vector3d(-1, 2, 0.1), points[17]}) {
    const PointIndex::Neighbors all = BruteForce(points, p), nearest = index.Nearest(p, 7);
    ASSERT_EQ(nearest.size(), 7u);
    for (std::size_t i = 0; i < nearest.size(); ++i) EXPECT_DOUBLE_EQ(nearest[i].second, all[i].second);
    const double radius = std::sqrt(0.5 * (all[20].second + all[21].second));
    EXPECT_EQ(index.Within(p, radius).size(), 21u);
  }
}

TEST(PointIndex, GivesWhatThereIs) {
  const std::vector<Eigen::Vector3d> points = Scatter(3), none;
  EXPECT_EQ(PointIndex(points).Nearest({0, 0, 0}, 10).size(), 3u);
  EXPECT_TRUE(PointIndex(none).Nearest({0, 0, 0}, 1).empty());
}

}  // namespace
}  // namespace geond
