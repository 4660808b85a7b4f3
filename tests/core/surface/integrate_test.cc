// SPDX-License-Identifier: Apache-2.0
#include "core/surface/integrate.h"

#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "tests/core/surface/views.h"

namespace geond {
namespace {

using testing::ElementsAre;

// A view of one pixel by parallel rays along -z of T: `depth` below the plane z = 1, tilted by `tilt` about x.
RangeView OnePixel(double depth, double tilt, double residual) {
  RangeView view;
  view.sensor.projection = SensorModel::Projection::kOrthographic;
  view.sensor.columns = view.sensor.rows = view.image.columns = view.image.rows = 1;
  view.sensor.focal_u = view.sensor.focal_v = 1000.0;
  view.image.depth = {static_cast<float>(depth)};
  view.classes = {PixelClass::kObject};
  view.normals_S = {Eigen::Vector3f(0.0f, static_cast<float>(std::sin(tilt)), static_cast<float>(-std::cos(tilt)))};
  view.normal_residuals = {static_cast<float>(residual)};
  Eigen::Matrix3d R;
  R << 1, 0, 0, 0, -1, 0, 0, 0, -1;
  view.X_TS = Pose(R, {0, 0, 1});
  return view;
}

TEST(IntegrateViews, OfRedundantDataTheOneSeenMostSquarelyIsKept) {
  const std::vector<RangeView> views{OnePixel(0.5, 0.6, 1e-5), OnePixel(0.5, 0.1, 9e-5), OnePixel(0.5, 0.9, 1e-6)};
  EXPECT_THAT(IntegrateViews(views, {.distance = 1e-3}).views, ElementsAre(1));
}

TEST(IntegrateViews, OfEqualCosinesTheOneWithTheSmallerResidualIsKept) {
  const std::vector<RangeView> views{OnePixel(0.5, 0.10, 9e-5), OnePixel(0.5, 0.2, 1e-5), OnePixel(0.5, 0.05, 8e-5)};
  const PointCloud merged = IntegrateViews(views, {.distance = 1e-3});
  EXPECT_THAT(merged.views, ElementsAre(1));
  EXPECT_NEAR(merged.normal_residuals[0], 1e-5, 1e-11);
}

TEST(IntegrateViews, OfEqualDataTheEarlierViewIsKept) {
  const std::vector<RangeView> views{OnePixel(0.5, 0.10, 1.1e-5), OnePixel(0.5, 0.12, 1e-5), OnePixel(0.5, 0.05, 1.05e-5)};
  EXPECT_THAT(IntegrateViews(views, {.distance = 1e-3}).views, ElementsAre(0));
}

TEST(IntegrateViews, DataApartInSpaceAreNotRedundant) {
  const std::vector<RangeView> views{OnePixel(0.5, 0, 1e-5), OnePixel(0.5009, 0, 1e-5), OnePixel(0.503, 0, 1e-5)};
  EXPECT_THAT(IntegrateViews(views, {.distance = 1e-3}).views, ElementsAre(0, 2));
  EXPECT_THAT(IntegrateViews(views, {.distance = 5e-4}).views, ElementsAre(0, 1, 2));
  // By itself: one and a half times the pitch of 1 mm.
  EXPECT_THAT(IntegrateViews(views).views, ElementsAre(0, 2));
}

TEST(IntegrateViews, TheResultIsInTheFrameOfTheTable) {
  const PointCloud merged = IntegrateViews(std::vector{OnePixel(0.25, 0.3, 1e-5)});
  ASSERT_EQ(merged.size(), 1u);
  EXPECT_LT((merged.points[0] - Eigen::Vector3d(0, 0, 0.75)).norm(), 1e-7);
  EXPECT_LT((merged.normals[0] - Eigen::Vector3d(0, -std::sin(0.3), std::cos(0.3))).norm(), 1e-6);
}

TEST(IntegrateViews, OnlyObjectDataWithNormalsTakePart) {
  RangeView without = OnePixel(0.5, 0, 1e-5), rejected = without, table = without;
  without.normals_S[0].setConstant(std::numeric_limits<float>::quiet_NaN());
  rejected.classes[0] = PixelClass::kRejected;
  table.classes[0] = PixelClass::kTable;
  EXPECT_TRUE(IntegrateViews(std::vector{without, rejected, table}).empty());
  EXPECT_TRUE(IntegrateViews({}).empty());
  without.normals_S.clear();
  EXPECT_THROW(IntegrateViews(std::vector{without}), std::invalid_argument);
}

std::vector<RangeView> SphereViews(int n) {
  std::vector<RangeView> views;
  for (int i = 0; i < n; ++i) {
    const Eigen::Vector3d center(0, 0, 0.05);
    views.push_back(MakeView(SphereObject(center, 0.05), LookingAt(center, 0.45, 2 * std::numbers::pi * i / n, 0.35), 80, 0.26));
  }
  return views;
}

TEST(IntegrateViews, ASphereIsCoveredOnceAndEvenly) {
  const std::vector<RangeView> views = SphereViews(8);
  std::size_t before = 0;
  for (const RangeView& view : views) before += ViewCloud(view).size();
  const PointCloud merged = IntegrateViews(views);
  EXPECT_LT(merged.size(), 0.45 * before);
  for (std::size_t i = 0; i < merged.size(); ++i) {
    const Eigen::Vector3d out = merged.points[i] - Eigen::Vector3d(0, 0, 0.05);
    EXPECT_NEAR(out.norm(), 0.05, 1e-6);
    EXPECT_GT(out.normalized().dot(merged.normals[i]), 0.9999);
  }
  // Nothing that was seen is lost: every datum has one of the merged cloud near it.
  for (const RangeView& view : views) {
    const PointCloud cloud = Transform(view.X_TS, ViewCloud(view));
    for (std::size_t i = 0; i < cloud.size(); i += 17) {
      double nearest = 1e9;
      for (const Eigen::Vector3d& p : merged.points) nearest = std::min(nearest, (p - cloud.points[i]).norm());
      EXPECT_LT(nearest, 0.004);
    }
  }
}

TEST(IntegrateViews, IsTheSameForAnyNumberOfThreads) {
  const std::vector<RangeView> views = SphereViews(5);
  const PointCloud one = IntegrateViews(views, {.threads = 1}), four = IntegrateViews(views, {.threads = 4});
  EXPECT_EQ(one.points, four.points);
  EXPECT_EQ(one.views, four.views);
}

TEST(IntegrateViews, StopsWhenAsked) {
  std::stop_source stop;
  stop.request_stop();
  EXPECT_THROW(IntegrateViews(SphereViews(2), {}, stop.get_token()), Cancelled);
}

}  // namespace
}  // namespace geond
