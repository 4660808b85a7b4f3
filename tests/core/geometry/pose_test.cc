// SPDX-License-Identifier: Apache-2.0
#include "core/geometry/pose.h"

#include <limits>
#include <numbers>
#include <stdexcept>
#include <vector>

#include <gtest/gtest.h>

namespace geond {
namespace {

std::vector<Pose> SamplePoses() {
  std::vector<Pose> poses = {Pose(), Pose::Translation({1, -2, 3}), Pose::Rotation({0, 0, 1}, 0.5),
                             Pose::Rotation({1, 2, 3}, std::numbers::pi), Pose::Rotation({0, 1, 0}, -3.0)};
  poses.push_back(poses[1] * poses[3]);
  poses.push_back(poses[4] * poses[1] * poses[2]);
  return poses;
}

void ExpectNear(const Pose& a, const Pose& b) {
  EXPECT_LT((a.translation() - b.translation()).norm(), 1e-14);
  EXPECT_LT((a.matrix() - b.matrix()).norm(), 1e-14);
}

TEST(Pose, IsAGroup) {
  const Eigen::Vector3d p(0.3, -0.7, 1.9);
  for (const Pose& a : SamplePoses()) {
    ExpectNear(a * Inverse(a), Pose());
    ExpectNear(Inverse(a) * a, Pose());
    ExpectNear(a * Pose(), a);
    EXPECT_LT((Inverse(a) * (a * p) - p).norm(), 1e-14);
    for (const Pose& b : SamplePoses()) {
      EXPECT_LT(((a * b) * p - a * (b * p)).norm(), 2e-14);
      ExpectNear(Inverse(a * b), Inverse(b) * Inverse(a));
      for (const Pose& c : SamplePoses()) EXPECT_LT((((a * b) * c) * p - (a * (b * c)) * p).norm(), 2e-14);
    }
  }
}

TEST(Pose, KeepsLengthsAndTurnsDirectionsWithoutMovingThem) {
  const Eigen::Vector3d p(0.3, -0.7, 1.9), q(-1.0, 0.2, 0.1);
  for (const Pose& a : SamplePoses()) {
    EXPECT_NEAR((a * p - a * q).norm(), (p - q).norm(), 1e-14);
    EXPECT_LT((a.Rotate(p - q) - (a * p - a * q)).norm(), 1e-14);
    EXPECT_NEAR(a.matrix().determinant(), 1.0, 1e-14);
  }
}

TEST(Pose, RotationIsRightHanded) {
  const Pose quarter = Pose::Rotation({0, 0, 2}, std::numbers::pi / 2);
  EXPECT_LT((quarter * Eigen::Vector3d::UnitX() - Eigen::Vector3d::UnitY()).norm(), 1e-15);
}

TEST(Pose, MatrixAndQuaternionSayTheSame) {
  for (const Pose& a : SamplePoses()) {
    ExpectNear(Pose(a.matrix(), a.translation()), a);
    ExpectNear(Pose(Eigen::Quaterniond(a.rotation().coeffs() * -3.0), a.translation()), a);
  }
}

TEST(Pose, StaysARotationOverManyProducts) {
  const Pose step = Pose::Translation({1e-3, 0, 0}) * Pose::Rotation({1, 2, -1}, 0.7);
  Pose product;
  for (int i = 0; i < 100000; ++i) product = product * step;
  EXPECT_NEAR(product.rotation().norm(), 1.0, 1e-15);
  EXPECT_LT((product.matrix() * product.matrix().transpose() - Eigen::Matrix3d::Identity()).norm(), 1e-14);
}

TEST(Pose, RefusesWhatIsNoRigidMotion) {
  const Eigen::Vector3d zero = Eigen::Vector3d::Zero();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(Pose(Eigen::Quaterniond(0, 0, 0, 0), zero), std::invalid_argument);
  EXPECT_THROW(Pose(Eigen::Quaterniond(1, nan, 0, 0), zero), std::invalid_argument);
  EXPECT_THROW(Pose(Eigen::Quaterniond::Identity(), Eigen::Vector3d(0, nan, 0)), std::invalid_argument);
  EXPECT_THROW(Pose(Eigen::Matrix3d(2.0 * Eigen::Matrix3d::Identity()), zero), std::invalid_argument);
  EXPECT_THROW(Pose(Eigen::Matrix3d(-Eigen::Matrix3d::Identity()), zero), std::invalid_argument);
  EXPECT_THROW(Pose(Eigen::Matrix3d(Eigen::Matrix3d::Constant(nan)), zero), std::invalid_argument);
}

}  // namespace
}  // namespace geond
