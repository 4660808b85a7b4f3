// SPDX-License-Identifier: Apache-2.0
#include "core/geometry/stray_points.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace geond {
namespace {

// Points on a sphere of radius 50 mm about `center`.
void AddBall(PointCloud& cloud, int n, const Eigen::Vector3d& center, double radius, std::mt19937_64& random) {
  const auto uniform = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };
  for (int i = 0; i < n; ++i) {
    const double z = 2.0 * uniform() - 1.0, angle = 2.0 * M_PI * uniform(), r = std::sqrt(1.0 - z * z);
    cloud.points.push_back(center + radius * Eigen::Vector3d(r * std::cos(angle), r * std::sin(angle), z));
    cloud.normals.push_back((cloud.points.back() - center).normalized());
  }
}

TEST(WithoutStrayPoints, LeavesOutSmallGroupsFarFromTheRestAndSaysSo) {
  std::mt19937_64 random(1);
  PointCloud cloud;
  AddBall(cloud, 15, {0.3, 0.0, 0.0}, 0.002, random);
  AddBall(cloud, 2000, {0.0, 0.0, 0.0}, 0.05, random);
  AddBall(cloud, 1, {0.0, -0.2, 0.0}, 0.0, random);
  std::vector<std::string> notes;
  const PointCloud clean = WithoutStrayPoints(cloud, 0.02, &notes);
  EXPECT_EQ(clean.size(), 2000u);
  EXPECT_EQ(clean.normals.size(), 2000u);
  for (const Eigen::Vector3d& p : clean.points) EXPECT_LT(p.norm(), 0.051);
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_EQ(notes[0], "16 stray points, apart from the rest, were left out");
}

TEST(WithoutStrayPoints, KeepsBodiesApartFromEachOtherAndSparseClouds) {
  std::mt19937_64 random(2);
  PointCloud two;
  AddBall(two, 2000, {0.0, 0.0, 0.0}, 0.05, random);
  AddBall(two, 300, {0.3, 0.0, 0.0}, 0.02, random);
  EXPECT_EQ(WithoutStrayPoints(two).size(), two.size());

  PointCloud strewn;  // a third of it far from everything
  AddBall(strewn, 400, {0.0, 0.0, 0.0}, 0.05, random);
  for (int i = 0; i < 200; ++i) AddBall(strewn, 1, Eigen::Vector3d(i % 10, i / 10, 1.0), 0.0, random);
  EXPECT_EQ(WithoutStrayPoints(strewn).size(), strewn.size());
}

TEST(WithoutStrayPoints, DoesNotDependOnTheUnit) {
  std::mt19937_64 random(3);
  PointCloud cloud;
  AddBall(cloud, 1000, {0.0, 0.0, 0.0}, 0.05, random);
  AddBall(cloud, 5, {0.2, 0.1, 0.0}, 0.001, random);
  PointCloud large = cloud;
  for (Eigen::Vector3d& p : large.points) p *= 1024.0;
  EXPECT_EQ(WithoutStrayPoints(cloud).size(), 1000u);
  EXPECT_EQ(WithoutStrayPoints(large).size(), 1000u);
}

TEST(WithoutStrayPoints, SurvivesPointsThatCoincide) {
  PointCloud cloud;
  cloud.points.assign(200, Eigen::Vector3d(1.0, 2.0, 3.0));
  EXPECT_EQ(WithoutStrayPoints(cloud).size(), 200u);
  EXPECT_TRUE(WithoutStrayPoints({}).empty());
}

}  // namespace
}  // namespace geond
