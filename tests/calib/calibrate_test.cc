// SPDX-License-Identifier: Apache-2.0
#include "calib/calibrate.h"

#include <algorithm>
#include <cmath>
#include <fstream>

#include <gtest/gtest.h>

#include "calib/calibration_file.h"
#include "calib/target_sphere.h"
#include "core/base/error.h"
#include "tests/calib/calibration_scans.h"

namespace geond::calib {
namespace {

constexpr double kDegree = M_PI / 180.0;

double AngleBetweenAxes(const StationGeometry& a, const StationGeometry& b) {
  return std::acos(std::min(1.0, a.X_WT.Rotate(Eigen::Vector3d::UnitZ()).dot(b.X_WT.Rotate(Eigen::Vector3d::UnitZ()))));
}

bool Says(const CalibrationResult& result, const std::string& words) {
  return std::any_of(result.reasons.begin(), result.reasons.end(),
                     [&](const std::string& reason) { return reason.find(words) != std::string::npos; });
}

TEST(FitSphere, FindsCentreAndRadiusAmongOutliers) {
  Noise random(4);
  std::vector<Eigen::Vector3d> points;
  const Eigen::Vector3d center(0.1, -0.2, 0.4);
  for (int k = 0; k < 300; ++k) {
    Eigen::Vector3d d = random.Vector().normalized();
    if (d.z() > 0) d = -d;
    points.push_back(center + (k % 20 == 0 ? 0.028 : 0.030) * d);
  }
  const SphereFit fit = FitSphere(points, center + Eigen::Vector3d(0.002, 0.001, 0.004), 0.0);
  EXPECT_LT((fit.center - center).norm(), 1e-7);
  EXPECT_NEAR(fit.radius, 0.030, 1e-7);
}

TEST(FindTarget, FindsTheSphereWithAStationThatIsOff) {
  const WrongStation world(2.0 * kDegree, 0.005, 2);
  const auto placement = world.Place({0.045, 0.0}, 0.040, 4, 9);
  for (const auto& exposure : placement.exposures) {
    const auto sighting = FindTarget(exposure, world.assumed, 0.020);
    ASSERT_TRUE(sighting);
    const Pose X_TS = SensorInTurntable(world.truth, exposure.table_angle);
    EXPECT_LT((X_TS * sighting->center_S - Eigen::Vector3d(0.045, 0.0, 0.020)).norm(), 0.004);
    EXPECT_GT(sighting->table.size(), 100u);
  }
  EXPECT_FALSE(FindTarget(placement.exposures[0], world.assumed, 0.055));
}

TEST(CalibrateStation, FindsAxisAndScaleAndProvesThemOnACheckSphere) {
  const WrongStation world(2.0 * kDegree, 0.005, 3);
  const auto result = CalibrateStation(world.assumed, world.Target(5), world.Check(5));
  EXPECT_TRUE(result.accepted) << testing::PrintToString(result.reasons) << testing::PrintToString(result.notes);
  EXPECT_LT(AngleBetweenAxes(result.calibration.station, world.truth), 0.05 * kDegree);
  EXPECT_LT(std::abs(result.calibration.check_error), 1e-4);
  EXPECT_LT(result.departure, 1e-4);
  // A check by geometry that the fit had no part in: where a point of the table's axis lies.
  const Pose X_SaT = Inverse(world.truth.X_WS) * result.calibration.station.X_WT;
  const Pose X_StT = Inverse(world.truth.X_WS) * world.truth.X_WT;
  const Eigen::Vector3d at = X_SaT * Eigen::Vector3d(0, 0, 0.03), truth = X_StT * Eigen::Vector3d(0, 0, 0.03);
  EXPECT_LT((at - truth).norm(), 0.0015);  // offset and scale of depth trade against each other along the ray
}

TEST(CalibrateStation, NoiseMakesNothingSmaller) {
  // Least squares in corrected units would gain by a smaller scale: 0.13 mm on this sphere at twice the usual noise.
  WrongStation world(2.0 * kDegree, 0.005, 8);
  world.noise = 0.0004;
  const auto result = CalibrateStation(world.assumed, world.Target(5), world.Check(5));
  EXPECT_LT(std::abs(result.calibration.check_error), 6e-5) << testing::PrintToString(result.notes);
}

TEST(CalibrateStation, SaysThatTheTargetSlipped) {
  WrongStation world(0.5 * kDegree, 0.002, 4);
  auto target = world.Target(6);
  world.slip = [](int image) { return image < 3 ? Eigen::Vector3d::Zero() : Eigen::Vector3d(0.0008, -0.0007, 0.0); };
  target[1] = world.Place({-0.015, 0.030}, 0.040, 8, 1006, 0.040);
  world.slip = nullptr;
  const auto result = CalibrateStation(world.assumed, target, world.Check(6));
  EXPECT_FALSE(result.accepted);
  EXPECT_TRUE(Says(result, "placement 2 moved")) << testing::PrintToString(result.reasons);
}

TEST(CalibrateStation, SaysThatTheAxisIsBent) {
  WrongStation world(0.5 * kDegree, 0.002, 5);
  // The bearing gives: the table leans to one side twice a turn.
  world.wobble = [](double angle) {
    return Pose::Rotation(Eigen::Vector3d::UnitX(), 0.008 * std::sin(2.0 * angle)) *
           Pose::Translation({0.0, 0.0005 * std::sin(2.0 * angle), 0.0});
  };
  const auto result = CalibrateStation(world.assumed, world.Target(7), world.Check(7));
  EXPECT_FALSE(result.accepted);
  EXPECT_TRUE(Says(result, "axis is bent")) << testing::PrintToString(result.reasons);
}

TEST(CalibrateStation, SaysThatADiameterIsWrong) {
  const WrongStation world(0.5 * kDegree, 0.002, 6);
  auto target = world.Target(8);
  for (auto& placement : target) placement.diameter = 0.0404;
  const auto result = CalibrateStation(world.assumed, target, world.Check(8));
  EXPECT_FALSE(result.accepted);
  EXPECT_TRUE(Says(result, "diameter")) << testing::PrintToString(result.reasons);
}

TEST(CalibrateStation, AsksForWhatIsMissing) {
  const WrongStation world(0.5 * kDegree, 0.002, 7);
  const auto one = CalibrateStation(world.assumed, {world.Place({0.045, 0.0}, 0.04, 4, 1)}, {});
  EXPECT_TRUE(Says(one, "one placement"));
  EXPECT_FALSE(one.accepted);
  EXPECT_THROW(CalibrateStation(world.assumed, {TargetPlacement{}}, {}), std::invalid_argument);
}

TEST(CalibrationFile, ComesBackAsItWas) {
  StationCalibration calibration;
  calibration.station = SyntheticStation();
  calibration.station.X_WT = Pose(Eigen::Quaterniond(0.9, 0.1, 0.2, 0.3), {0.01, 0.02, 0.03});
  calibration.depth_scale = 1.004;
  calibration.depth_offset = -0.0005;
  calibration.check_error = 3e-5;
  calibration.date = "2026-01-02T03:04:05Z";
  calibration.name = "bench \"two\"";
  const auto path = std::filesystem::temp_directory_path() / "geond_calibration_test.json";
  WriteCalibration(calibration, path);
  const StationCalibration read = ReadCalibration(path);
  EXPECT_EQ(read.name, calibration.name);
  EXPECT_EQ(read.date, calibration.date);
  EXPECT_NEAR(read.depth_offset, calibration.depth_offset, 1e-15);
  EXPECT_EQ(read.depth_scale, calibration.depth_scale);
  EXPECT_EQ(read.station.sensor.focal_u, calibration.station.sensor.focal_u);
  EXPECT_LT((read.station.X_WT.translation() - calibration.station.X_WT.translation()).norm(), 1e-15);
  EXPECT_LT(read.station.X_WT.rotation().angularDistance(calibration.station.X_WT.rotation()), 1e-7);

  std::string text;
  std::getline(std::ifstream(path), text, '\0');
  const auto refused = [&](const std::string& what, const std::string& by) {
    std::string changed = text;
    changed.replace(changed.find(what), what.size(), by);
    std::ofstream(path) << changed;
    try {
      ReadCalibration(path);
    } catch (const FileError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_NE(refused("\"version\": 1", "\"version\": 7").find("version"), std::string::npos);
  EXPECT_NE(refused("depth_scale", "depth_scald").find("sensor/depth_scale"), std::string::npos);
  EXPECT_NE(refused("1.004", "\"x\"").find("not a number"), std::string::npos);
  EXPECT_NE(refused("{", "").find("JSON"), std::string::npos);
  std::filesystem::remove(path);
}

}  // namespace
}  // namespace geond::calib
