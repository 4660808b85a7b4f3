// SPDX-License-Identifier: Apache-2.0
#include "core/geometry/cloud_normals.h"

#include <cmath>
#include <stdexcept>

#include <gtest/gtest.h>

namespace geond {
namespace {

// Points of the cap of a unit sphere about `pole` down to 60 degrees from it.
PointCloud SphereCap(const Eigen::Vector3d& pole) {
  PointCloud cloud;
  for (int i = 0; i < 3000; ++i) {
    const double z = 1.0 - 2.0 * (i + 0.5) / 3000, radius = std::sqrt(1.0 - z * z), angle = 2.399963 * i;
    const Eigen::Vector3d p(radius * std::cos(angle), radius * std::sin(angle), z);
    if (p.dot(pole) > 0.5) cloud.points.push_back(p);
  }
  return cloud;
}

TEST(EstimateCloudNormals, FindsTheNormalsOfASphere) {
  const PointCloud cloud = EstimateCloudNormals(SphereCap({0, 0, 1}));
  for (std::size_t i = 0; i < cloud.size(); ++i) EXPECT_GT(std::abs(cloud.normals[i].dot(cloud.points[i])), 0.98);
}

TEST(EstimateCloudNormals, DoesNotDependOnTheNumberOfThreads) {
  const PointCloud one = EstimateCloudNormals(SphereCap({1, 0, 0}), 12, 1), three = EstimateCloudNormals(SphereCap({1, 0, 0}), 12, 3);
  EXPECT_EQ(one.normals, three.normals);
}

TEST(EstimateCloudNormals, RefusesTooFewPoints) {
  PointCloud cloud;
  cloud.points.resize(5);
  EXPECT_THROW(EstimateCloudNormals(cloud, 20), std::invalid_argument);
}

TEST(GuessViewingSide, IsThePoleOfACapSeenFromOutside) {
  for (const Eigen::Vector3d& pole : {Eigen::Vector3d(0, 0, 1), Eigen::Vector3d(0, 0, -1), Eigen::Vector3d(0.6, -0.8, 0)}) {
    const Eigen::Vector3d side = GuessViewingSide(EstimateCloudNormals(SphereCap(pole)));
    EXPECT_GT(side.dot(pole), 0.5) << pole.transpose();
    const PointCloud oriented = OrientTowards(EstimateCloudNormals(SphereCap(pole)), 100.0 * side);
    for (std::size_t i = 0; i < oriented.size(); ++i) EXPECT_GT(oriented.normals[i].dot(oriented.points[i]), 0.9);
  }
}

TEST(WithOutwardNormals, PointOutOfABallAndTowardsASensorFarFromOneSide) {
  PointCloud ball = SphereCap({0, 0, 1});
  for (const Eigen::Vector3d& p : SphereCap({0, 0, -1}).points) ball.points.push_back(p);
  for (int i = 0; i < 3000; ++i) {
    const double z = 0.5 - (i + 0.5) / 3000, radius = std::sqrt(1.0 - z * z);
    ball.points.push_back({radius * std::cos(2.399963 * i), radius * std::sin(2.399963 * i), z});
  }
  const PointCloud round = WithOutwardNormals(ball);
  for (std::size_t i = 0; i < round.size(); ++i) EXPECT_GT(round.normals[i].dot(round.points[i]), 0.8);

  std::vector<std::string> notes;
  PointCloud cap = SphereCap({0, 0, -1});  // looked at from below, the sensor at the origin
  for (Eigen::Vector3d& p : cap.points) p.z() += 10.0;
  const PointCloud seen = WithOutwardNormals(cap, &notes);
  for (std::size_t i = 0; i < seen.size(); ++i) EXPECT_LT(seen.normals[i].dot(seen.points[i]), 0.0);
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_NE(notes[0].find("origin"), std::string::npos);
}

}  // namespace
}  // namespace geond
