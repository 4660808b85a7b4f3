// SPDX-License-Identifier: Apache-2.0
#include "core/geometry/point_cloud.h"

#include <stdexcept>

#include <gtest/gtest.h>

namespace geond {
namespace {

PointCloud Sample() {
  PointCloud cloud;
  cloud.points = {{1, 2, 3}, {-1, 0, 5}, {0.5, 7, -2}};
  cloud.normals = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  cloud.normal_residuals = {0.1, 0.2, 0.3};
  cloud.views = {0, 1, 1};
  return cloud;
}

TEST(PointCloud, TransformMovesPointsAndOnlyTurnsNormals) {
  const Pose pose = Pose::Translation({5, -1, 2}) * Pose::Rotation({0, 1, 1}, 1.2);
  const PointCloud there = Transform(pose, Sample()), back = Transform(Inverse(pose), there);
  for (int i = 0; i < 3; ++i) {
    EXPECT_LT((there.points[i] - pose * Sample().points[i]).norm(), 1e-15);
    EXPECT_NEAR(there.normals[i].norm(), 1.0, 1e-15);
    EXPECT_LT((back.points[i] - Sample().points[i]).norm(), 1e-14);
    EXPECT_LT((back.normals[i] - Sample().normals[i]).norm(), 1e-14);
  }
  EXPECT_EQ(there.normal_residuals, Sample().normal_residuals);
  EXPECT_EQ(there.views, Sample().views);
}

TEST(PointCloud, SelectKeepsOrderAndAllThatIsKnown) {
  const PointCloud some = Select(Sample(), {2, 0, 2});
  ASSERT_EQ(some.size(), 3u);
  EXPECT_EQ(some.points[0], Sample().points[2]);
  EXPECT_EQ(some.normals[1], Sample().normals[0]);
  EXPECT_EQ(some.normal_residuals, (std::vector<double>{0.3, 0.1, 0.3}));
  EXPECT_EQ(some.views, (std::vector<int>{1, 0, 1}));
  PointCloud bare;
  bare.points = Sample().points;
  EXPECT_FALSE(Select(bare, {1}).has_normals());
  EXPECT_THROW(Select(bare, {3}), std::out_of_range);
}

TEST(PointCloud, BoundingBoxHoldsEveryPoint) {
  const Eigen::AlignedBox3d box = BoundingBox(Sample().points);
  EXPECT_EQ(box.min(), Eigen::Vector3d(-1, 0, -2));
  EXPECT_EQ(box.max(), Eigen::Vector3d(1, 7, 5));
  EXPECT_THROW(BoundingBox({}), std::invalid_argument);
}

}  // namespace
}  // namespace geond
