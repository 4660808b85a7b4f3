// SPDX-License-Identifier: Apache-2.0
#include "calib/make_view.h"

#include <gtest/gtest.h>

#include "calib/table_shift.h"
#include "tests/calib/synthetic_scan.h"

namespace geond::calib {
namespace {

double BoxSphereDistance(const SyntheticScene& scene, const Eigen::Vector3d& p) {
  double best = std::abs((p - scene.spheres[0].center).norm() - scene.spheres[0].radius);
  const auto& box = scene.boxes[0];
  const Eigen::Vector3d middle = 0.5 * (box.low + box.high), half = 0.5 * (box.high - box.low);
  const Eigen::Vector3d q = (p - middle).cwiseAbs() - half;
  return std::min(best, std::abs(q.cwiseMax(0.0).norm() + std::min(0.0, q.maxCoeff())));
}

TEST(MakeViews, KeepsTheObjectAndNothingOfTheTable) {
  const SyntheticScene scene = BoxAndSphere();
  const auto made = MakeViewsAndTables(SyntheticScan(scene, 4, 0.0002));
  ASSERT_EQ(made.views.size(), 4u);
  for (const auto& view : made.views) {
    const PointCloud cloud = Transform(view.X_TS, ViewCloud(view));
    ASSERT_GT(cloud.size(), 800u);
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      ASSERT_LT(BoxSphereDistance(scene, cloud.points[i]), 0.0012);
      ASSERT_GT(cloud.points[i].z(), 0.0005);
    }
    EXPECT_GT(std::count(view.classes.begin(), view.classes.end(), PixelClass::kTable), 3000);
  }
}

TEST(MakeViews, FollowsATableThatTheCalibrationHasWrong) {
  const SyntheticScene scene = BoxAndSphere();
  RecordedScan scan = SyntheticScan(scene, 3, 0.0002);
  // The station believes the table 3 mm lower and tilted by half a degree: uncorrected, all of it would be object.
  const Pose wrong = Pose::Translation({0, 0, 0.003}) * Pose::Rotation(Eigen::Vector3d::UnitX(), 0.0087);
  for (auto& view : scan.views) view.X_TS_measured = wrong * view.X_TS_measured;
  const auto made = MakeViewsAndTables(scan);
  for (std::size_t k = 0; k < made.views.size(); ++k) {
    ASSERT_TRUE(made.tables[k].refined);
    EXPECT_NEAR(made.tables[k].offset, 0.003, 1e-4);
    EXPECT_NEAR(made.tables[k].Tilt(), 0.0087, 5e-4);
    const PointCloud cloud = Transform(Inverse(wrong) * made.views[k].X_TS, ViewCloud(made.views[k]));
    for (const auto& p : cloud.points) ASSERT_LT(BoxSphereDistance(scene, p), 0.0012);
  }
  ASSERT_FALSE(made.notes.empty());
  EXPECT_NE(made.notes.back().find("+3.0"), std::string::npos) << made.notes.back();
}

TEST(MakeViews, TakesEveryReturnWhereThereIsNoTable) {
  SyntheticScene scene = BoxAndSphere();
  scene.table = false;
  const auto views = MakeViews(SyntheticScan(scene, 2, 0.0));
  for (const auto& view : views) {
    for (std::size_t i = 0; i < view.classes.size(); ++i) {
      const bool returned = std::isfinite(view.image.depth[i]);
      EXPECT_EQ(view.classes[i] == PixelClass::kNothing, !returned);
      if (returned) {
        EXPECT_TRUE(view.classes[i] == PixelClass::kObject || view.classes[i] == PixelClass::kRejected);
      }
    }
  }
}

TEST(MakeView, RejectsPixelsThatHangBetweenTwoSurfaces) {
  const SyntheticScene scene = BoxAndSphere();
  RecordedScan scan = SyntheticScan(scene, 1, 0.0);
  RangeImage& image = scan.views[0].exposure.image;
  const auto clean = MakeView(scan.views[0].exposure, scan.station);
  // Beside each jump to the table behind, the object's last pixel is put half way.
  std::vector<std::size_t> veiled;
  for (int v = 2; v < image.rows - 2; ++v) {
    for (int u = 2; u < image.columns - 2; ++u) {
      const std::size_t i = image.index(u, v);
      if (clean.classes[i] != PixelClass::kObject || clean.classes[i + 1] != PixelClass::kTable) continue;
      if (clean.image.depth[i + 1] - clean.image.depth[i] < 0.03f) continue;
      image.depth[i] = 0.5f * (clean.image.depth[i] + clean.image.depth[i + 1]);
      veiled.push_back(i);
    }
  }
  ASSERT_GT(veiled.size(), 10u);
  const auto view = MakeView(scan.views[0].exposure, scan.station);
  for (const std::size_t i : veiled) EXPECT_NE(view.classes[i], PixelClass::kObject) << i;
}

TEST(MakeView, RefusesAnImageOfAnotherSize) {
  RecordedScan scan = SyntheticScan(BoxAndSphere(), 1, 0.0);
  scan.station.sensor.columns -= 1;
  EXPECT_THROW(MakeView(scan.views[0].exposure, scan.station), std::invalid_argument);
}

TEST(FitTablePlane, FindsTheTableUnderAPlateThatHidesMostOfIt) {
  std::vector<Eigen::Vector3d> points;
  Noise random(3);
  for (int k = 0; k < 4000; ++k) {
    const Eigen::Vector2d xy(0.1 * random.Normal(), 0.1 * random.Normal());
    points.emplace_back(xy.x(), xy.y(), (k % 4 ? 0.004 : 0.0) + 0.0001 * random.Normal());
  }
  const TablePlane plane = FitTablePlane(points);
  ASSERT_TRUE(plane.refined);
  EXPECT_NEAR(plane.offset, 0.0, 5e-5);
}

TEST(FitTablePlane, KeepsTheCalibratedPlaneWithTooFewReturns) {
  const std::vector<Eigen::Vector3d> points(50, Eigen::Vector3d(0, 0, 0.002));
  const TablePlane plane = FitTablePlane(points);
  EXPECT_FALSE(plane.refined);
  EXPECT_EQ(plane.Height({0.1, 0.1, 0.5}), 0.5);
}

TEST(ShiftOntoTable, PutsTheTableTopThatWasSeenAtZero) {
  auto views = MakeViews(SyntheticScan(BoxAndSphere(), 4, 0.0002));
  for (RangeView& view : views) view.X_TS = Pose::Translation({0.0, 0.0, 0.0007}) * view.X_TS;
  EXPECT_NEAR(ShiftOntoTable(views), -0.0007, 2e-5);
  EXPECT_NEAR(ShiftOntoTable(views), 0.0, 1e-6);
  for (RangeView& view : views) view.classes.assign(view.classes.size(), PixelClass::kNothing);
  EXPECT_EQ(ShiftOntoTable(views), 0.0);
}

}  // namespace
}  // namespace geond::calib
