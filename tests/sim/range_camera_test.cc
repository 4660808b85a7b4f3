// SPDX-License-Identifier: Apache-2.0
#include "sim/range_camera.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "sim/simulate_scan.h"

namespace geond::sim {
namespace {

Scene One(GeonType type, const Eigen::Vector3d& size, const Pose& X_TG, Eigen::Vector2d taper = {0, 0},
          double bend = 0) {
  Scene scene;
  scene.parts.push_back({"it", {type, X_TG, size, taper, bend}});
  return scene;
}

Pose SensorOf(const StationGeometry& station) { return SensorInTurntable(station, 0.0); }

int CountSame(const RangeImage& a, const RangeImage& b) {
  int same = 0;
  for (std::size_t i = 0; i < a.depth.size(); ++i) {
    same += (std::isnan(a.depth[i]) && std::isnan(b.depth[i])) || a.depth[i] == b.depth[i];
  }
  return same;
}

TEST(RangeCamera, SphereDepthIsTheClosedForm) {
  const double radius = 0.05;
  const Eigen::Vector3d center(0.01, -0.02, 0.05);
  Scene scene = One(GeonType::kEllipsoid, Eigen::Vector3d::Constant(radius), Pose::Translation(center));
  scene.table_radius = scene.wall_distance = 0.0;
  const SceneGeometry geometry(scene);
  const StationGeometry station = MakeStation();
  const Pose X_TS = SensorOf(station);
  int on_sphere = 0, missed = 0;
  for (int row = 0; row < station.sensor.rows; row += 3) {
    for (int column = 0; column < station.sensor.columns; column += 3) {
      const Eigen::Vector3d direction_S = RayDirection(station.sensor, column, row);
      const Eigen::Vector3d d = X_TS.Rotate(direction_S), o = X_TS.translation() - center;
      const double half = o.dot(d), discriminant = half * half - o.squaredNorm() + radius * radius;
      const double depth = TrueDepth(geometry, station.sensor, X_TS, column, row);
      if (discriminant < 0.0) {
        EXPECT_TRUE(std::isnan(depth)) << column << " " << row;
        continue;
      }
      if (std::isnan(depth)) {
        ++missed;
        continue;
      }
      ++on_sphere;
      // The root moves as error of rounding / slope; grazing rays are bounded by the geometry itself.
      EXPECT_NEAR(depth, (-half - std::sqrt(discriminant)) * direction_S.z(), 1e-9) << column << " " << row;
    }
  }
  EXPECT_GT(on_sphere, 1000);
  EXPECT_EQ(missed, 0);
}

TEST(RangeCamera, TableAndWallArePlanes) {
  Scene scene = One(GeonType::kEllipsoid, {0.01, 0.01, 0.01}, Pose::Translation({0, 0, 0.01}));
  const SceneGeometry geometry(scene);
  const StationGeometry station = MakeStation();
  const Pose X_TS = SensorOf(station);
  const double depth = TrueDepth(geometry, station.sensor, X_TS, 160, 310);
  const Eigen::Vector3d on_table = X_TS * Unproject(station.sensor, 160, 310, depth);
  EXPECT_NEAR(on_table.z(), 0.0, 1e-12);
  EXPECT_LT(on_table.head<2>().norm(), scene.table_radius);
  const Eigen::Vector3d on_wall =
      X_TS * Unproject(station.sensor, 160, 0, TrueDepth(geometry, station.sensor, X_TS, 160, 0));
  EXPECT_NEAR(on_wall.y(), 0.6, 1e-9);
}

// Every depth of every type lies on the surface by its own equation, and nothing lies before it on the ray.
TEST(RangeCamera, EveryTypeIsMetOnItsSurfaceAndNotBefore) {
  const Pose X_TG = Pose::Translation({0.005, 0.0, 0.06}) * Pose::Rotation(Eigen::Vector3d(1, 2, 3), 0.7);
  const StationGeometry station = MakeStation();
  const Pose X_TS = SensorOf(station);
  for (const GeonType type : kGeonTypes) {
    Geon geon{type, X_TG, {0.02, 0.025, 0.05}, {0, 0}, 0.0};
    if (IsTapered(type)) geon.taper = {0.5, 0.3};
    if (IsCurved(type)) geon.bend = 25.0;
    Scene scene;
    scene.parts.push_back({"it", geon});
    scene.table_radius = scene.wall_distance = 0.0;
    const SceneGeometry geometry(scene);
    const GeonSurface surface(geon);
    int met = 0;
    for (int row = 0; row < 320; row += 9) {
      for (int column = 0; column < 320; column += 9) {
        const double depth = TrueDepth(geometry, station.sensor, X_TS, column, row);
        const Eigen::Vector3d origin = X_TS.translation();
        const Eigen::Vector3d direction = X_TS.Rotate(RayDirection(station.sensor, column, row));
        const double range = depth / RayDirection(station.sensor, column, row).z();
        const double last = std::isnan(depth) ? 0.7 : range - 1e-6;
        if (!std::isnan(depth)) {
          ++met;
          EXPECT_NEAR(surface.At(origin + range * direction).value, 1.0, 1e-9);
        }
        for (double t = 0.35; t < last; t += 0.001) {
          ASSERT_GT(surface.At(origin + t * direction).value, 1.0)
              << GeonTypeName(type) << " pixel " << column << " " << row << " is inside at " << t << " of " << range;
        }
      }
    }
    EXPECT_GT(met, 30) << GeonTypeName(type);
  }
}

TEST(GeonSurface, GradientIsTheDerivative) {
  const Pose X_TG = Pose::Translation({0.01, 0.02, 0.03}) * Pose::Rotation(Eigen::Vector3d(1, 2, 3), 0.7);
  for (const GeonType type : kGeonTypes) {
    Geon geon{type, X_TG, {0.02, 0.025, 0.05}, {0, 0}, 0.0};
    if (IsTapered(type)) geon.taper = {0.5, 0.3};
    if (IsCurved(type)) geon.bend = 25.0;
    const GeonSurface surface(geon);
    for (int i = 0; i < 50; ++i) {
      const Eigen::Vector3d direction(std::sin(1.0 + i), std::cos(2.0 * i), std::sin(3.0 * i + 0.5));
      const Eigen::Vector3d p = surface.PointAlong(direction);
      const auto value = surface.At(p);
      EXPECT_NEAR(value.value, 1.0, 1e-12);
      for (int axis = 0; axis < 3; ++axis) {
        const Eigen::Vector3d h = 1e-7 * Eigen::Vector3d::Unit(axis);
        const double slope = (surface.At(p + h).value - surface.At(p - h).value) / 2e-7;
        EXPECT_NEAR(value.gradient[axis], slope, 2e-5 * (1.0 + std::abs(slope))) << GeonTypeName(type);
      }
    }
  }
}

TEST(RangeCamera, NoiseIsNormalAndGrowsWithIncidenceAndRange) {
  Scene scene = One(GeonType::kEllipsoid, {0.001, 0.001, 0.001}, Pose::Translation({0.15, 0, 0.001}));
  scene.table_radius = 10.0;
  const SceneGeometry geometry(scene);
  for (const double elevation : {1.2, 0.5}) {
    StationGeometry station = MakeStation(0.45, elevation, 0.0, 200, 200, 0.02, 0.0002);
    CameraOptions options = CameraOptions::Perfect();
    const Pose X_TS = SensorOf(station);
    const RangeImage image = TakeRangeImage(geometry, station.sensor, X_TS, options, 7, 0, 1);
    double sum = 0.0, sum2 = 0.0;
    int n = 0, beyond = 0;
    for (int row = 0; row < 200; ++row) {
      for (int column = 0; column < 200; ++column, ++n) {
        const double error = image.at(column, row) - TrueDepth(geometry, station.sensor, X_TS, column, row);
        const double unit = error / (0.0002 / std::sin(elevation));
        sum += unit, sum2 += unit * unit, beyond += std::abs(unit) > 1.96;
      }
    }
    EXPECT_NEAR(sum / n, 0.0, 4.0 / std::sqrt(n));
    EXPECT_NEAR(std::sqrt(sum2 / n), 1.0, 0.05);
    EXPECT_NEAR(static_cast<double>(beyond) / n, 0.05, 0.01);
  }
}

TEST(RangeCamera, ReturnsFailWhereTheRayGrazes) {
  Scene scene = One(GeonType::kCylinder, {0.04, 0.04, 0.06}, Pose::Translation({0, 0, 0.06}));
  scene.table_radius = scene.wall_distance = 0.0;
  const SceneGeometry geometry(scene);
  const StationGeometry station = MakeStation(0.45, 0.3);
  const Pose X_TS = SensorOf(station);
  CameraOptions options;
  const RangeImage image = TakeRangeImage(geometry, station.sensor, X_TS, options, 1, 0);
  int steep = 0, steep_lost = 0, straight = 0, straight_lost = 0;
  for (int row = 0; row < 320; ++row) {
    for (int column = 0; column < 320; ++column) {
      const Ray ray{X_TS.translation(), X_TS.Rotate(RayDirection(station.sensor, column, row))};
      const auto hit = geometry.Cast(ray, Eigen::Vector3d::Zero());
      if (hit.item != 0) continue;
      const bool lost = std::isnan(image.at(column, row));
      const double incidence = std::acos(hit.cos_incidence);
      if (incidence > options.dropout_end) ++steep, steep_lost += lost;
      if (incidence < options.dropout_begin) ++straight, straight_lost += lost;
    }
  }
  EXPECT_GT(steep, 10);
  EXPECT_EQ(steep_lost, steep);
  EXPECT_GT(straight, 1000);
  EXPECT_EQ(straight_lost, 0);
}

TEST(RangeCamera, MixedPixelsLieBetweenTheSidesOfAJump) {
  Scene scene = One(GeonType::kCuboid, {0.04, 0.04, 0.04}, Pose::Translation({0, 0, 0.04}));
  const SceneGeometry geometry(scene);
  StationGeometry station = MakeStation();
  station.sensor.depth_noise = 0.0;
  const Pose X_TS = SensorOf(station);
  CameraOptions options = CameraOptions::Perfect();
  const RangeImage clean = TakeRangeImage(geometry, station.sensor, X_TS, options, 1, 0);
  options.mixed_pixel_probability = 1.0;
  const RangeImage mixed = TakeRangeImage(geometry, station.sensor, X_TS, options, 1, 0);
  int changed = 0;
  for (int row = 1; row < 319; ++row) {
    for (int column = 1; column < 319; ++column) {
      if (clean.at(column, row) == mixed.at(column, row)) continue;
      ++changed;
      float low = clean.at(column, row), high = low;
      for (const auto& [c, r] : {std::pair{column - 1, row}, {column + 1, row}, {column, row - 1}, {column, row + 1}}) {
        low = std::min(low, clean.at(c, r)), high = std::max(high, clean.at(c, r));
      }
      EXPECT_GT(high - low, options.mixed_pixel_jump);
      EXPECT_GE(mixed.at(column, row), low);
      EXPECT_LE(mixed.at(column, row), high);
    }
  }
  EXPECT_GT(changed, 100);
  EXPECT_LT(changed, 2000);
}

TEST(RangeCamera, DepthIsAWholeNumberOfQuanta) {
  const SceneGeometry geometry(One(GeonType::kCuboid, {0.04, 0.04, 0.04}, Pose::Translation({0, 0, 0.04})));
  const StationGeometry station = MakeStation();
  CameraOptions options;
  const RangeImage image = TakeRangeImage(geometry, station.sensor, SensorOf(station), options, 1, 0);
  for (const float depth : image.depth) {
    if (std::isnan(depth)) continue;
    const double count = std::round(depth / options.depth_quantum);
    ASSERT_EQ(depth, static_cast<float>(count * options.depth_quantum));
    ASSERT_LT(count, 65536);
  }
}

TEST(RangeCamera, SameBitsForAnyNumberOfThreadsAndOtherBitsForOtherSeeds) {
  const SceneGeometry geometry(One(GeonType::kCylinder, {0.03, 0.03, 0.05}, Pose::Translation({0, 0, 0.05})));
  const StationGeometry station = MakeStation(0.45, 0.5, 0.05, 120, 120);
  const Pose X_TS = SensorOf(station);
  const RangeImage one = TakeRangeImage(geometry, station.sensor, X_TS, {}, 5, 2, 1);
  const RangeImage four = TakeRangeImage(geometry, station.sensor, X_TS, {}, 5, 2, 4);
  EXPECT_EQ(CountSame(one, four), 120 * 120);
  EXPECT_LT(CountSame(one, TakeRangeImage(geometry, station.sensor, X_TS, {}, 6, 2, 1)), 120 * 60);
  EXPECT_LT(CountSame(one, TakeRangeImage(geometry, station.sensor, X_TS, {}, 5, 3, 1)), 120 * 60);
}

TEST(SimulateScan, RepeatsToTheBitAndCarriesTheTruth) {
  const Scene scene = One(GeonType::kCuboid, {0.03, 0.04, 0.05}, Pose::Translation({0, 0, 0.05}));
  SimOptions options;
  options.views = 4;
  options.columns = options.rows = 100;
  options.seed = 9;
  options.threads = 1;
  const RecordedScan a = SimulateScan(scene, options);
  options.threads = 3;
  const RecordedScan b = SimulateScan(scene, options);
  ASSERT_EQ(a.views.size(), 4u);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(CountSame(a.views[i].exposure.image, b.views[i].exposure.image), 100 * 100);
    EXPECT_NEAR(a.views[i].exposure.table_angle, 0.5 * std::numbers::pi * i, 1e-15);
  }
  EXPECT_NE(a.truth.find("\"cuboid\""), std::string::npos);
  EXPECT_NE(a.truth.find("50.0"), std::string::npos);
  EXPECT_EQ(a.seed, 9u);
  std::stop_source stop;
  stop.request_stop();
  EXPECT_THROW(SimulateScan(scene, options, stop.get_token()), Cancelled);
}

// With exact poses the points of all views lie on the one true surface; with a wrong axis they do not.
TEST(SimulateScan, ViewsMeetInTheTurntableFrame) {
  const Scene scene = One(GeonType::kCuboid, {0.03, 0.04, 0.05}, Pose::Translation({0, 0, 0.05}));
  const GeonSurface surface(scene.parts[0].geon);
  const auto worst = [&](const SimOptions& options) {
    double largest = 0.0;
    for (const auto& view : SimulateScan(scene, options).views) {
      for (int row = 0; row < options.rows; ++row) {
        for (int column = 0; column < options.columns; ++column) {
          const double depth = view.exposure.image.at(column, row);
          const Eigen::Vector3d p = view.X_TS_measured * Unproject(view.sensor, column, row, depth);
          if (std::isnan(depth) || p.z() < 0.005 || p.head<2>().norm() > 0.08) continue;
          const auto value = surface.At(p);
          largest = std::max(largest, std::abs(value.value - 1.0) / value.gradient.norm());
        }
      }
    }
    return largest;
  };
  SimOptions options;
  options.views = 3;
  options.columns = options.rows = 60;
  options.depth_noise = options.angle_noise = 0.0;
  options.camera = CameraOptions::Perfect();
  options.axis_error = {0.0, 0.0, 0.0, 0.0};
  EXPECT_LT(worst(options), 1e-7);
  options.axis_error.offset_x = 0.001;
  EXPECT_GT(worst(options), 5e-4);
}

}  // namespace
}  // namespace geond::sim
