// SPDX-License-Identifier: Apache-2.0
#include "core/range/range_view.h"

#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <numbers>
#include <random>
#include <stdexcept>

#include <gtest/gtest.h>

namespace geond {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

SensorModel PerspectiveSensor(int columns = 60, int rows = 50) {
  SensorModel sensor;
  sensor.columns = columns;
  sensor.rows = rows;
  sensor.focal_u = 520.0;
  sensor.focal_v = 515.0;
  sensor.center_u = 0.5 * columns;
  sensor.center_v = 0.45 * rows;
  return sensor;
}

SensorModel OrthographicSensor(int columns = 60, int rows = 50) {
  SensorModel sensor = PerspectiveSensor(columns, rows);
  sensor.projection = SensorModel::Projection::kOrthographic;
  sensor.focal_u = 1000.0;
  sensor.focal_v = 1100.0;
  return sensor;
}

// A view whose depth at (column, row) is depth_of(ray origin, unit direction); NaN is no return.
RangeView MakeView(const SensorModel& sensor,
                   const std::function<double(const Eigen::Vector3d&, const Eigen::Vector3d&)>& range_of) {
  RangeView view;
  view.sensor = sensor;
  view.image = {sensor.columns, sensor.rows, {}};
  for (int row = 0; row < sensor.rows; ++row) {
    for (int column = 0; column < sensor.columns; ++column) {
      const Eigen::Vector3d direction = RayDirection(sensor, column, row);
      const Eigen::Vector3d origin = sensor.projection == SensorModel::Projection::kPerspective
                                         ? Eigen::Vector3d::Zero()
                                         : Unproject(sensor, column, row, 0.0);
      const double range = range_of(origin, direction);
      view.image.depth.push_back(static_cast<float>(origin.z() + range * direction.z()));
      view.classes.push_back(std::isfinite(range) ? PixelClass::kObject : PixelClass::kNothing);
    }
  }
  return view;
}

double PlaneRange(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, const Eigen::Vector3d& normal,
                  double distance) {
  return (distance - normal.dot(origin)) / normal.dot(direction);
}

double SphereRange(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, const Eigen::Vector3d& center,
                   double radius) {
  const double b = direction.dot(origin - center);
  const double c = (origin - center).squaredNorm() - radius * radius;
  return b * b < c ? std::numeric_limits<double>::quiet_NaN() : -b - std::sqrt(b * b - c);
}

TEST(EstimateNormals, IsExactOnPlanes) {
  for (const SensorModel& sensor : {PerspectiveSensor(), OrthographicSensor()}) {
    for (double tilt : {0.0, 20.0, 55.0, 70.0}) {
      const Eigen::Vector3d normal = Pose::Rotation({0.3, 1.0, 0.0}, tilt * kDegree).Rotate(-Eigen::Vector3d::UnitZ());
      const RangeView view = EstimateNormals(MakeView(sensor, [&](const auto& origin, const auto& direction) {
        return PlaneRange(origin, direction, normal, -0.45 * std::cos(tilt * kDegree));
      }));
      int n = 0;
      for (std::size_t i = 0; i < view.classes.size(); ++i) {
        if (!view.IsObject(i)) continue;
        ++n;
        // The depths are floats: 3e-8 m over a window of some millimetres.
        EXPECT_LT((view.normals_S[i].cast<double>() - normal).norm(), 2e-4) << "tilt " << tilt;
        EXPECT_LT(view.normal_residuals[i], 1e-7f);
      }
      EXPECT_EQ(n, sensor.columns * sensor.rows) << "tilt " << tilt;
    }
  }
}

TEST(EstimateNormals, FollowsASphereAndPointsToTheSensor) {
  for (const SensorModel& sensor : {PerspectiveSensor(160, 160), OrthographicSensor(160, 160)}) {
    const Eigen::Vector3d center(0.0, 0.0, 0.45);
    const double radius = 0.05;
    const RangeView view = EstimateNormals(MakeView(sensor, [&](const auto& origin, const auto& direction) {
      return SphereRange(origin, direction, center, radius);
    }));
    const PointCloud cloud = ViewCloud(view);
    ASSERT_GT(cloud.size(), 5000u);
    double worst_facing = 0.0;
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      const Eigen::Vector3d truth = (cloud.points[i] - center).normalized();
      const double facing = sensor.projection == SensorModel::Projection::kPerspective
                                ? -cloud.normals[i].dot(cloud.points[i].normalized())
                                : -cloud.normals[i].z();
      EXPECT_GT(facing, 0.0);
      EXPECT_NEAR((cloud.points[i] - center).norm(), radius, 1e-7);
      if (facing > 0.35) worst_facing = std::max(worst_facing, std::acos(std::min(1.0, truth.dot(cloud.normals[i]))));
    }
    EXPECT_LT(worst_facing, 3.0 * kDegree);
  }
}

TEST(EstimateNormals, IsUnbiasedUnderNoiseAlongTheRay) {
  const SensorModel base = PerspectiveSensor(120, 120);
  SensorModel sensor = base;
  sensor.depth_noise = 0.0003;
  const Eigen::Vector3d normal = Pose::Rotation({0.0, 1.0, 0.0}, 50 * kDegree).Rotate(-Eigen::Vector3d::UnitZ());
  std::mt19937_64 generator(11);
  std::normal_distribution<double> noise(0.0, sensor.depth_noise);
  const RangeView view = EstimateNormals(MakeView(sensor, [&](const auto& origin, const auto& direction) {
    return PlaneRange(origin, direction, normal, 0.45 * normal.z()) + noise(generator);
  }));
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  double mean_residual = 0.0;
  int n = 0;
  for (std::size_t i = 0; i < view.classes.size(); ++i) {
    if (!view.IsObject(i)) continue;
    mean += view.normals_S[i].cast<double>();
    mean_residual += view.normal_residuals[i];
    ++n;
  }
  ASSERT_GT(n, 14000);
  EXPECT_LT(std::acos(mean.normalized().dot(normal)), 0.7 * kDegree);
  // Noise along the ray appears along the normal times the cosine; 25 points less 3 degrees of freedom.
  EXPECT_NEAR(mean_residual / n, sensor.depth_noise * std::cos(50 * kDegree), 0.00005);
}

TEST(EstimateNormals, DoesNotBlendAcrossADepthJump) {
  const SensorModel sensor = PerspectiveSensor(60, 50);
  RangeView view = MakeView(
      sensor, [&](const auto&, const auto& direction) { return (direction.x() < 0.0 ? 0.40 : 0.50) / direction.z(); });
  view = EstimateNormals(std::move(view));
  for (int row = 0; row < sensor.rows; ++row) {
    for (int column = 0; column < sensor.columns; ++column) {
      const std::size_t pixel = view.image.index(column, row);
      ASSERT_TRUE(view.IsObject(pixel)) << column << " " << row;
      EXPECT_GT(-view.normals_S[pixel].z(), 0.999f);
    }
  }
}

TEST(EstimateNormals, RejectsFlyingPixelsBetweenTwoSurfaces) {
  const SensorModel sensor = PerspectiveSensor(60, 50);
  RangeView view = MakeView(
      sensor, [&](const auto&, const auto& direction) { return (direction.x() < 0.0 ? 0.40 : 0.50) / direction.z(); });
  const int edge = 30;  // the first column of the far surface
  for (int row = 0; row < sensor.rows; ++row) view.image.depth[view.image.index(edge, row)] = 0.45f;
  view = EstimateNormals(std::move(view));
  for (int row = 0; row < sensor.rows; ++row) {
    EXPECT_EQ(view.classes[view.image.index(edge, row)], PixelClass::kRejected);
    EXPECT_EQ(view.classes[view.image.index(edge - 1, row)], PixelClass::kObject);
    EXPECT_EQ(view.classes[view.image.index(edge + 1, row)], PixelClass::kObject);
  }
}

TEST(EstimateNormals, RejectsGrazingSurfaces) {
  NormalOptions options;
  options.max_incidence = 60 * kDegree;
  for (double tilt : {50.0, 70.0}) {
    const Eigen::Vector3d normal = Pose::Rotation({1.0, 0.0, 0.0}, tilt * kDegree).Rotate(-Eigen::Vector3d::UnitZ());
    const RangeView view = EstimateNormals(MakeView(OrthographicSensor(),
                                                    [&](const auto& origin, const auto& direction) {
                                                      return PlaneRange(origin, direction, normal, 0.45 * normal.z());
                                                    }),
                                           options);
    for (std::size_t i = 0; i < view.classes.size(); ++i) {
      EXPECT_EQ(view.classes[i], tilt < 60 ? PixelClass::kObject : PixelClass::kRejected);
      EXPECT_EQ(view.normals_S[i].allFinite(), tilt < 60);
    }
  }
}

TEST(EstimateNormals, LeavesPixelsOutsideTheObjectAlone) {
  RangeView view =
      MakeView(PerspectiveSensor(), [](const auto&, const auto& direction) { return 0.4 / direction.z(); });
  for (std::size_t i = 0; i < view.classes.size(); ++i) {
    if (i % 60 < 20) view.classes[i] = i % 2 ? PixelClass::kTable : PixelClass::kBackground;
  }
  const std::vector<PixelClass> before = view.classes;
  view = EstimateNormals(std::move(view));
  EXPECT_EQ(view.classes, before);
  for (std::size_t i = 0; i < before.size(); ++i)
    EXPECT_EQ(view.normals_S[i].allFinite(), before[i] == PixelClass::kObject);
  EXPECT_EQ(ViewCloud(view).size(), 40u * 50u);
}

TEST(EstimateNormals, RejectsLonelyPixelsAndLines) {
  RangeView view =
      MakeView(PerspectiveSensor(), [](const auto&, const auto& direction) { return 0.4 / direction.z(); });
  std::fill(view.classes.begin(), view.classes.end(), PixelClass::kNothing);
  for (int row = 0; row < 50; ++row) view.classes[view.image.index(10, row)] = PixelClass::kObject;
  view.classes[view.image.index(30, 30)] = PixelClass::kObject;
  NormalOptions options;
  options.window = 9;  // eight neighbours in the line: enough, but no plane
  view = EstimateNormals(std::move(view), options);
  for (int row = 0; row < 50; ++row) EXPECT_EQ(view.classes[view.image.index(10, row)], PixelClass::kRejected);
  EXPECT_EQ(view.classes[view.image.index(30, 30)], PixelClass::kRejected);
  EXPECT_TRUE(ViewCloud(view).empty());
}

TEST(EstimateNormals, GivesTheSameBitsForAnyNumberOfThreads) {
  const auto estimate = [](int threads) {
    return EstimateNormals(MakeView(PerspectiveSensor(90, 80),
                                    [](const auto& origin, const auto& direction) {
                                      return SphereRange(origin, direction, {0, 0, 0.45}, 0.03);
                                    }),
                           {}, threads);
  };
  const RangeView one = estimate(1);
  for (int threads : {2, 3, 8}) {
    const RangeView many = estimate(threads);
    EXPECT_EQ(one.classes, many.classes);
    EXPECT_EQ(
        0, std::memcmp(one.normals_S.data(), many.normals_S.data(), one.normals_S.size() * sizeof(one.normals_S[0])));
    EXPECT_EQ(0,
              std::memcmp(one.normal_residuals.data(), many.normal_residuals.data(), 4 * one.normal_residuals.size()));
  }
}

TEST(EstimateNormals, RefusesWhatCannotBe) {
  RangeView view = MakeView(PerspectiveSensor(), [](const auto&, const auto&) { return 0.4; });
  NormalOptions even;
  even.window = 4;
  EXPECT_THROW(EstimateNormals(view, even), std::invalid_argument);
  view.classes.pop_back();
  EXPECT_THROW(EstimateNormals(view), std::invalid_argument);
}

TEST(ViewCloud, IsEmptyWithoutNormals) {
  const RangeView view = MakeView(PerspectiveSensor(), [](const auto&, const auto&) { return 0.4; });
  EXPECT_TRUE(ViewCloud(view).empty());
}

}  // namespace
}  // namespace geond
