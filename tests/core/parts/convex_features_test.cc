// SPDX-License-Identifier: Apache-2.0
#include "core/parts/convex_features.h"

#include <algorithm>
#include <cmath>
#include <set>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "tests/core/parts/segmentation_case.h"

namespace geond {
namespace {

using Kind = ConvexFeature::Kind;

test::SegmentationCase Case(const std::string& name) {
  return test::ReadSegmentationCase(GEOND_TEST_DATA "/segmentation", name);
}

TEST(FindConvexFeatures, ABallLikeBodyHasNone) {
  const test::SegmentationCase c = Case("clean1500_ellipsoid");
  EXPECT_TRUE(FindConvexFeatures(c.mesh, c.charge).empty());
}

TEST(FindConvexFeatures, FindsFeetHeadAndTailOfAnAnimal) {
  const test::SegmentationCase c = Case("clean1500_animal");
  const std::vector<ConvexFeature> features = FindConvexFeatures(c.mesh, c.charge);
  ASSERT_GE(features.size(), 5u);
  std::set<int> parts;  // the true parts that carry a tip: all limbs, hardly the trunk
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& v : c.mesh.vertices) middle += v / static_cast<double>(c.mesh.vertices.size());
  for (const ConvexFeature& feature : features) {
    ASSERT_FALSE(feature.triangles.empty());
    parts.insert(c.labels[feature.triangles[feature.triangles.size() / 2]]);
    EXPECT_GE(feature.strength, 2.0);
    EXPECT_NEAR(feature.direction.norm(), 1.0, 1e-9);
    if (feature.kind == Kind::kTip) {
      EXPECT_GT(feature.direction.dot(feature.position - middle), 0.0);
    }
  }
  EXPECT_GE(parts.size(), 5u);
  for (std::size_t i = 1; i < features.size(); ++i) EXPECT_LE(features[i].strength, features[i - 1].strength);
}

// A round rod, charged as a closed form might have it: high along one line of its side, and at one end.
TEST(FindConvexFeatures, TellsAnEdgeFromATip) {
  TriangleMesh mesh;
  ChargeDensity charge;
  const int around = 24, along = 60;
  for (int i = 0; i <= along; ++i) {
    for (int k = 0; k < around; ++k) {
      const double a = 2.0 * M_PI * k / around;
      mesh.vertices.emplace_back(std::cos(a), std::sin(a), 10.0 * i / along);
    }
  }
  for (int i = 0; i < along; ++i) {
    for (int k = 0; k < around; ++k) {
      const int a = i * around + k, b = i * around + (k + 1) % around;
      mesh.triangles.push_back({a, b, a + around});
      mesh.triangles.push_back({b, b + around, a + around});
    }
  }
  for (int t = 0; t < static_cast<int>(mesh.triangles.size()); ++t) {
    const Eigen::Vector3d x = TriangleCentroid(mesh, t);
    const double line = x.z() > 2.0 && x.z() < 8.0
                            ? std::exp(-0.5 * std::pow((x - Eigen::Vector3d(1, 0, x.z())).norm() / 0.25, 2))
                            : 0.0;
    const double spot = std::exp(-0.5 * (x - Eigen::Vector3d(-1, 0, 9)).squaredNorm() / 0.1);
    charge.density.push_back(1.0 + 4.0 * line + 8.0 * spot);
  }
  const std::vector<ConvexFeature> features = FindConvexFeatures(mesh, charge);
  ASSERT_EQ(features.size(), 2u);
  const auto& tip = features[0].kind == Kind::kTip ? features[0] : features[1];
  const auto& edge = features[0].kind == Kind::kTip ? features[1] : features[0];
  EXPECT_EQ(tip.kind, Kind::kTip);
  EXPECT_EQ(edge.kind, Kind::kEdge);
  EXPECT_LT((tip.position - Eigen::Vector3d(-1, 0, 9)).norm(), 0.3);
  EXPECT_LT(tip.direction.x(), -0.9);
  EXPECT_GT(std::abs(edge.direction.z()), 0.95);
  EXPECT_NEAR(edge.length, 6.0, 0.6);
}

TEST(FindConvexFeatures, TurnsAndScalesWithTheObject) {
  const test::SegmentationCase c = Case("clean1500_animal");
  const std::vector<ConvexFeature> features = FindConvexFeatures(c.mesh, c.charge);
  TriangleMesh moved = c.mesh;
  const Eigen::Matrix3d R = Eigen::AngleAxisd(0.8, Eigen::Vector3d(1, 2, -0.5).normalized()).toRotationMatrix();
  for (auto& v : moved.vertices) v = 0.01 * (R * v);
  const std::vector<ConvexFeature> again = FindConvexFeatures(moved, c.charge);
  ASSERT_EQ(again.size(), features.size());
  for (std::size_t i = 0; i < features.size(); ++i) {
    EXPECT_NEAR(again[i].strength, features[i].strength, 1e-6 * features[i].strength);
    EXPECT_LT((again[i].position - 0.01 * R * features[i].position).norm(), 1e-6);
  }
}

TEST(FindConvexFeatures, ThrowsIfTheChargeIsOfAnotherMesh) {
  const test::SegmentationCase c = Case("clean1500_ellipsoid");
  EXPECT_THROW(FindConvexFeatures(c.mesh, {}), std::invalid_argument);
  EXPECT_TRUE(FindConvexFeatures({}, {}).empty());
}

}  // namespace
}  // namespace geond
