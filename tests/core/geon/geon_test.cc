// SPDX-License-Identifier: Apache-2.0
#include "core/geon/geon.h"

#include <cmath>
#include <numbers>
#include <stdexcept>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/geon/shape.h"
#include "tests/core/geon/random_geon.h"

namespace geond {
namespace {

class EveryType : public testing::TestWithParam<GeonType> {};
INSTANTIATE_TEST_SUITE_P(Geon, EveryType, testing::ValuesIn(kGeonTypes),
                         [](const auto& type) { return std::string(GeonTypeName(type.param)); });

TEST(GeonTypeFromName, IsTheInverseOfTheNameAndListsTheNames) {
  for (const GeonType type : kGeonTypes) EXPECT_EQ(GeonTypeFromName(GeonTypeName(type)), type);
  try {
    GeonTypeFromName("cone");
    FAIL();
  } catch (const std::invalid_argument& e) {
    EXPECT_THAT(e.what(), testing::HasSubstr("tapered_cuboid"));
  }
}

TEST_P(EveryType, UndeformIsTheInverseOfDeform) {
  Draw draw(1);
  for (int i = 0; i < 500; ++i) {
    Geon geon = RandomGeon(GetParam(), draw);
    if (i % 3 == 0) geon.bend = 0.0;
    if (i % 3 == 1) geon.bend *= 1e-7;
    // Half bending angles up to pi.
    if (i % 5 == 0) geon.bend = std::min(0.9 / geon.size.x(), draw.Uniform(1.0, 3.1) / geon.size.z());
    const Eigen::Vector3d x = geon.size.cwiseProduct(
        Eigen::Vector3d(draw.Uniform(-1, 1), draw.Uniform(-1, 1), draw.Uniform(-1, 1)));
    EXPECT_LT((Undeform(geon, Deform(geon, x)) - x).norm(), 1e-14 * geon.size.norm());
  }
}

TEST_P(EveryType, GaugeGradientIsTheSlopeOfTheGauge) {
  Draw draw(2);
  for (int i = 0; i < 200; ++i) {
    const Geon geon = RandomGeon(GetParam(), draw);
    const Eigen::Vector3d x = geon.size.cwiseProduct(draw.Normal3());
    const Eigen::Vector3d gradient = GaugeGradient(geon, x);
    const double h = 1e-6 * geon.size.minCoeff();
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d step = h * Eigen::Vector3d::Unit(k);
      EXPECT_NEAR(gradient[k], (Gauge(geon, x + step) - Gauge(geon, x - step)) / (2 * h), 1e-7 / geon.size.minCoeff());
    }
    EXPECT_NEAR(gradient.dot(x), Gauge(geon, x), 1e-12 * Gauge(geon, x));   // homogeneous of degree one
  }
}

TEST_P(EveryType, NormalsStandOnTheDeformedSurfaceAndPointOut) {
  Draw draw(3);
  for (int i = 0; i < 200; ++i) {
    const Geon geon = RandomGeon(GetParam(), draw);
    const Eigen::Vector3d direction = geon.size.cwiseProduct(draw.Normal3());
    const Eigen::Vector3d x = direction / Gauge(geon, direction);
    // Two tangents by moving the ray.
    const auto surface = [&](const Eigen::Vector3d& d) { return Deform(geon, d / Gauge(geon, d)); };
    const Eigen::Vector3d normal = SurfaceNormal(geon, direction);
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d step = 1e-6 * geon.size.minCoeff() * Eigen::Vector3d::Unit(k);
      const Eigen::Vector3d tangent = surface(x + step) - surface(x - step);
      EXPECT_NEAR(normal.dot(tangent) / (2e-6 * geon.size.minCoeff()), 0.0, 1e-6);
    }
    EXPECT_GT(Gauge(geon, Undeform(geon, Deform(geon, x) + 1e-4 * geon.size.minCoeff() * normal)), 1.0);
  }
}

TEST_P(EveryType, CanonicalKeepsTheShapeAndForgetsHowItWasGiven) {
  Draw draw(4);
  for (int i = 0; i < 100; ++i) {
    Geon geon = RandomGeon(GetParam(), draw);
    if (i % 4 == 0) geon.size.x() = geon.size.y();
    if (i % 4 == 0) geon.taper.x() = geon.taper.y();
    const Geon canonical = Canonical(geon);
    for (const Eigen::Vector3d& p : SampleGeon(geon, 50).points) {
      EXPECT_NEAR(Gauge(canonical, Undeform(canonical, Inverse(canonical.X_TG) * p)), 1.0, 1e-9);
    }
    // The same shape, its axes turned by 180 degrees about x: tapers and bends as they then read.
    Geon turned = geon;
    turned.X_TG = geon.X_TG * Pose::Rotation(Eigen::Vector3d::UnitX(), std::numbers::pi);
    turned.taper = -turned.taper;
    const Geon again = Canonical(turned);
    EXPECT_LT((again.size - canonical.size).norm(), 1e-12);
    EXPECT_LT((again.taper - canonical.taper).norm(), 1e-12);
    EXPECT_EQ(again.bend, canonical.bend);
    EXPECT_LT((again.X_TG.matrix() - canonical.X_TG.matrix()).norm(), 1e-7);
    EXPECT_GE(canonical.taper.minCoeff(), 0.0);
  }
}

TEST(Canonical, GivesASphereNoRotationAndACanNoTwist) {
  Draw draw(5);
  Geon sphere{.size = Eigen::Vector3d::Constant(0.02)};
  sphere.X_TG = Pose(draw.Rotation(), Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(Canonical(sphere).X_TG.rotation().w(), 1.0);

  Geon can{.type = GeonType::kCylinder, .size = {0.02, 0.02, 0.01}};
  can.X_TG = Pose::Rotation(Eigen::Vector3d::UnitZ(), 0.7);
  EXPECT_NEAR(Canonical(can).X_TG.rotation().w(), 1.0, 1e-15);

  Geon bent{.type = GeonType::kCurvedCylinder, .size = {0.01, 0.01, 0.03}, .bend = -20.0};
  EXPECT_EQ(Canonical(bent).bend, 20.0);
}

TEST_P(EveryType, SamplesLieOnTheSurfaceWithTheirNormals) {
  Draw draw(6);
  const Geon geon = RandomGeon(GetParam(), draw);
  const PointCloud cloud = SampleGeon(geon, 777);
  ASSERT_EQ(cloud.size(), 777u);
  ASSERT_TRUE(cloud.has_normals());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3d x = Undeform(geon, Inverse(geon.X_TG) * cloud.points[i]);
    EXPECT_NEAR(Gauge(geon, x), 1.0, 1e-12);
    EXPECT_NEAR(cloud.normals[i].norm(), 1.0, 1e-12);
    EXPECT_GT(geon.X_TG.Rotate(SurfaceNormal(geon, x)).dot(cloud.normals[i]), 1 - 1e-9);
  }
}

TEST_P(EveryType, MeshIsClosedManifoldOutwardAndOnTheSurface) {
  Draw draw(7);
  for (const double edge : {0.001, 0.004, 0.05}) {
    const Geon geon = RandomGeon(GetParam(), draw);
    const TriangleMesh mesh = GeonMesh(geon, edge);
    const MeshTopology topology = Topology(mesh);
    EXPECT_TRUE(topology.closed && topology.manifold);
    EXPECT_EQ(topology.components, 1);
    EXPECT_EQ(topology.genus, 0);
    for (const Eigen::Vector3d& p : mesh.vertices) {
      EXPECT_NEAR(Gauge(geon, Undeform(geon, Inverse(geon.X_TG) * p)), 1.0, 1e-9);
    }
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      const Eigen::Vector3d x = Undeform(geon, Inverse(geon.X_TG) * TriangleCentroid(mesh, static_cast<int>(t)));
      EXPECT_GT(geon.X_TG.Rotate(SurfaceNormal(geon, x)).dot(TriangleAreaVector(mesh, static_cast<int>(t))), 0.0);
    }
  }
}

// Volumes in closed form: ellipsoid 4/3 pi abc; |x|^20 + |y|^20 + |z|^20 <= 1 has (2 Gamma(1 + 1/20))^3 / Gamma(1 + 3/20); the
// cylinder 2 pi times the same integral over r dr dz, pi B(1 + 1/10, 1/20) / 10. A bend keeps the volume (its centre line is
// the middle fibre); a taper multiplies each slice by (1 + Kx z/az)(1 + Ky z/az).
TEST(GeonMesh, HasTheVolumeOfTheShape) {
  const Eigen::Vector3d a(0.02, 0.015, 0.05);
  const double box = std::pow(2 * std::tgamma(1.05), 3) / std::tgamma(1.15);
  const double can = std::numbers::pi * std::tgamma(1.1) * std::tgamma(0.05) / std::tgamma(1.15) / 10.0;
  const auto volume = [&](GeonType type, double bend) {
    Geon geon{.type = type, .size = a, .bend = bend};
    return Volume(GeonMesh(geon, 0.0008)) / a.prod();
  };
  EXPECT_NEAR(volume(GeonType::kEllipsoid, 0) / (4.0 / 3.0 * std::numbers::pi), 1.0, 2e-3);
  EXPECT_NEAR(volume(GeonType::kCuboid, 0) / box, 1.0, 2e-3);
  EXPECT_NEAR(volume(GeonType::kCylinder, 0) / can, 1.0, 2e-3);
  EXPECT_NEAR(volume(GeonType::kCurvedCuboid, 20.0) / box, 1.0, 2e-3);
  EXPECT_NEAR(volume(GeonType::kCurvedCylinder, 20.0) / can, 1.0, 2e-3);
}

TEST(GeonMesh, RefusesWhatIsNoGeon) {
  Geon geon;
  EXPECT_THROW(GeonMesh(geon, 0.0), std::invalid_argument);
  geon.size.x() = -1.0;
  EXPECT_THROW(GeonMesh(geon, 0.1), std::invalid_argument);
  EXPECT_THROW(SampleGeon(geon, 10), std::invalid_argument);
  Geon bent{.type = GeonType::kCurvedCylinder, .size = {1.0, 1.0, 1.0}, .bend = 1.5};
  EXPECT_THROW(SampleGeon(bent, 10), std::invalid_argument);
}

}  // namespace
}  // namespace geond
