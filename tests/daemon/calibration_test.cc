// SPDX-License-Identifier: Apache-2.0
#include <future>

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "daemon/calibration_store.h"
#include "tests/daemon/served_test.h"

namespace geond::daemon {
namespace {

constexpr double kDegree = 0.017453292519943295;

TEST(CalibrationStore, CountsPlacementsAndRemembersWhichIsInForce) {
  const TemporaryFolder folder;
  const CalibrationStore store(folder.path() / "calibrations");
  EXPECT_EQ(store.Current(), 0);
  EXPECT_TRUE(store.List().empty());
  const int first = store.Begin(0.04, 0.06, "2026-01-02T03:04:05Z"), second = store.Begin(0.04, 0.06, "2026-01-03T03:04:05Z");
  EXPECT_EQ(first, 1);
  EXPECT_EQ(second, 2);
  RecordedScan scan;
  scan.station = sim::MakeStation(0.450, 0.489, 0.045, 16, 16);
  RangeImage image{16, 16, std::vector<float>(256, 0.45f)};
  scan.views.push_back({{image, 0.5, {}}, scan.station.sensor, {}, std::nullopt});
  EXPECT_EQ(store.KeepPlacement(2, false, scan), 1);
  EXPECT_EQ(store.KeepPlacement(2, false, scan), 2);
  EXPECT_EQ(store.KeepPlacement(2, true, scan), 1);
  const auto target = store.Placements(2, false);
  ASSERT_EQ(target.size(), 2u);
  EXPECT_DOUBLE_EQ(target[0].diameter, 0.04);
  EXPECT_EQ(target[0].exposures.at(0).image.depth, image.depth);
  EXPECT_DOUBLE_EQ(store.Placements(2, true).at(0).diameter, 0.06);

  calib::CalibrationResult result;
  result.calibration.station = scan.station;
  result.reasons = {"the axis is bent"};
  store.KeepResult(1, result);
  EXPECT_THROW(store.Use(1), FileError);  // was not accepted
  result.accepted = true;
  result.reasons.clear();
  result.calibration.number = 2;
  store.KeepResult(2, result);
  store.Use(2);
  EXPECT_EQ(store.Current(), 2);
  EXPECT_EQ(store.Read(2).number, 2);
  const auto all = store.List();
  ASSERT_EQ(all.size(), 2u);
  EXPECT_EQ(all[0].reasons.at(0), "the axis is bent");
  EXPECT_TRUE(all[1].accepted);
  store.Use(0);
  EXPECT_EQ(store.Current(), 0);
  EXPECT_THROW(store.Summary(3), FileError);
}

// A simulated station whose axis and sensor are not as configured, asked as a client asks.
class CalibrationTest : public ServedTest {
 protected:
  CalibrationTest() : ServedTest(World()) { Open(); }

  static std::shared_ptr<sim::SimStation> World() {
    sim::StationOptions options;
    options.assumed = sim::MakeStation(0.450, 0.489, 0.045, 128, 128, 0.20);
    options.axis_error = {1.0 * kDegree, 0.7, 0.003, -0.002};
    options.sensor_error.depth_scale = -0.004;
    options.threads = 1;
    return std::make_shared<sim::SimStation>(Egg(), options);
  }
  void Open() {
    ServedTest::Open(SmallConfig(Config{}.scan_views), [this](const Json& event) {
      if (event["event"] == "scan" && event["state"] != "running") ended_.set_value(event);
    });
  }
  // Puts a sphere on the simulated table: diameter and place in mm.
  void PutSphere(double diameter, double x, double y, double lift) {
    const std::string radius = std::to_string(0.5 * diameter);
    Call("simulation.scene", {{"toml", "rest_on_table = false\n[[geon]]\ntype = \"ellipsoid\"\nsize_mm = [" + radius + ", " +
                                           radius + ", " + radius + "]\nposition_mm = [" + std::to_string(x) + ", " +
                                           std::to_string(y) + ", " + std::to_string(lift + 0.5 * diameter) + "]\n"}});
  }
  Json Calibrate(double told_target, double told_check) {
    const int number = Call("calibration.begin", {{"target_mm", told_target}, {"check_mm", told_check}})["calibration"].get<int>();
    const double places[3][3] = {{45, 0, 0}, {-15, 30, 40}, {0, -45, 15}};
    for (const auto& at : places) {
      PutSphere(40, at[0], at[1], at[2]);
      EXPECT_EQ(Call("calibration.place", {{"calibration", number}})["kept"], true);
    }
    PutSphere(60, 5, 10, 0);
    EXPECT_EQ(Call("calibration.place", {{"calibration", number}, {"check", true}, {"views", 6}})["found"], 6);
    return Call("calibration.solve", {{"calibration", number}});
  }

  std::promise<Json> ended_;
};

TEST_F(CalibrationTest, WhatIsAcceptedIsUsedByScansAndSurvivesARestart) {
  EXPECT_EQ(Call("calibration.show")["calibration"], 0);
  const Json result = Calibrate(40, 60);
  ASSERT_EQ(result["accepted"], true) << result.dump(2);
  EXPECT_EQ(result["in_force"], true);
  EXPECT_LT(std::abs(result["check_error_mm"].get<double>()), 0.1);
  Close();
  Open();
  EXPECT_EQ(Call("station.status")["calibration"]["calibration"], 1);

  Call("simulation.scene", {{"configured", true}});
  const int scan = Call("scan.start", {{"views", 4}})["scan"].get<int>();
  ASSERT_EQ(ended_.get_future().get()["state"], "done");
  const RecordedScan recorded = ReadScan(folder_.path() / "store" / "000001");
  EXPECT_EQ(scan, 1);
  ASSERT_TRUE(recorded.calibration);
  EXPECT_EQ(recorded.calibration->number, 1);
  EXPECT_NEAR(recorded.calibration->depth_scale, 1.0 / 0.996, 0.004);
  // The axis of the scan is the true one, among the points that the sensor measures.
  const Pose found = Inverse(recorded.station.X_WS) * recorded.station.X_WT;
  StationGeometry truth = world_->options().assumed;
  truth.X_WT = truth.X_WT * sim::AxisErrorPose(world_->options().axis_error);
  const Pose expected = Inverse(truth.X_WS) * truth.X_WT;
  EXPECT_GT(found.Rotate(Eigen::Vector3d::UnitZ()).dot(expected.Rotate(Eigen::Vector3d::UnitZ())), std::cos(0.1 * kDegree));

  EXPECT_EQ(Call("calibration.use", {{"calibration", 0}})["calibration"], 0);
  EXPECT_EQ(Call("calibration.list")["calibrations"].size(), 1u);
}

TEST_F(CalibrationTest, AWrongDiameterIsRejectedInWordsAndNotUsed) {
  const Json result = Calibrate(40.6, 60);
  EXPECT_EQ(result["accepted"], false);
  EXPECT_NE(result["reasons"].dump().find("diameter"), std::string::npos) << result.dump(2);
  EXPECT_EQ(Call("calibration.show")["calibration"], 0);
  EXPECT_EQ(Ask("calibration.use", {{"calibration", 1}})["error"]["data"]["name"], "unavailable");
}

TEST_F(CalibrationTest, ASphereThatIsNotThereIsNotKept) {
  const int number = Call("calibration.begin", {{"target_mm", 40}, {"check_mm", 60}})["calibration"].get<int>();
  const Json placed = Call("calibration.place", {{"calibration", number}, {"views", 4}});  // the egg stands there
  EXPECT_EQ(placed["kept"], false);
  EXPECT_FALSE(placed["remedy"].get<std::string>().empty());
  EXPECT_EQ(Call("calibration.list")["calibrations"][0]["targets"], 0);
  EXPECT_NE(Call("calibration.solve", {{"calibration", number}})["reasons"].dump().find("one placement"), std::string::npos);
  EXPECT_TRUE(Ask("calibration.place", {{"calibration", 9}}).contains("error"));
}

}  // namespace
}  // namespace geond::daemon
