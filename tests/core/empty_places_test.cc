// SPDX-License-Identifier: Apache-2.0
#include "core/empty_places.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "core/geon/geon.h"

namespace geond {
namespace {

// A ball of 20 mm at the origin, seen from 400 mm along its -z by an orthographic camera with 1 mm pixels; beside it
// the background, but for one quarter of the picture that gave no return.
RangeView ViewOfABall() {
  RangeView view;
  view.sensor.projection = SensorModel::Projection::kOrthographic;
  view.sensor.columns = view.sensor.rows = 101;
  view.sensor.focal_u = view.sensor.focal_v = 1000.0;
  view.sensor.center_u = view.sensor.center_v = 50.0;
  view.image.columns = view.image.rows = 101;
  for (int row = 0; row < 101; ++row) {
    for (int column = 0; column < 101; ++column) {
      const double x = (column - 50) * 1e-3, y = (row - 50) * 1e-3, square = 0.02 * 0.02 - x * x - y * y;
      const bool on_ball = square > 0.0, silent = !on_ball && x > 0.0 && y > 0.0;
      view.image.depth.push_back(
          static_cast<float>(on_ball ? 0.4 - std::sqrt(square) : std::numeric_limits<double>::quiet_NaN()));
      view.classes.push_back(on_ball ? PixelClass::kObject : silent ? PixelClass::kNothing : PixelClass::kBackground);
    }
  }
  view.X_TS = Pose::Translation({0, 0, -0.4});
  return view;
}

TEST(EmptyPlaces, LieBeforeAndBesideTheObjectAndNotBehindIt) {
  const RangeView view = ViewOfABall();
  Geon ball;
  ball.size = {0.02, 0.02, 0.02};
  const std::vector<Eigen::Vector3d> places = EmptyPlaces(std::span(&view, 1), false, SampleGeon(ball, 400));
  EXPECT_GT(places.size(), 100u);
  int before = 0, beside = 0;
  for (const Eigen::Vector3d& p : places) {
    EXPECT_GT(p.norm(), 0.02);
    const double across = std::hypot(p.x(), p.y());
    if (across < 0.019) {
      EXPECT_LT(p.z(), 0.0) << "behind the ball nothing is known";
    }
    if (across > 0.02) {
      EXPECT_FALSE(p.x() > 0.001 && p.y() > 0.001) << "nor where the sensor got no return";
    }
    before += across < 0.019;
    beside += across > 0.02;
  }
  EXPECT_GT(before, 10);
  EXPECT_GT(beside, 10);
}

TEST(EmptyPlaces, LieUnderTheTableOfAnObjectThatStandsOnIt) {
  Geon box;
  box.type = GeonType::kCuboid;
  box.size = {0.02, 0.02, 0.02};
  box.X_TG = Pose::Translation({0, 0, 0.02});
  const std::vector<Eigen::Vector3d> places = EmptyPlaces({}, true, SampleGeon(box, 400));
  EXPECT_GT(places.size(), 50u);
  for (const Eigen::Vector3d& p : places) EXPECT_LT(p.z(), 0.0);
  EXPECT_TRUE(EmptyPlaces({}, false, SampleGeon(box, 400)).empty());
}

TEST(EmptyPlaces, LieOutsideAClosedMesh) {
  Geon box;
  box.type = GeonType::kCuboid;
  box.size = {0.02, 0.03, 0.04};
  const std::vector<Eigen::Vector3d> places = EmptyPlaces(GeonMesh(box, 0.005), SampleGeon(box, 400));
  EXPECT_GT(places.size(), 200u);
  for (const Eigen::Vector3d& p : places) EXPECT_GT((p.array() / box.size.array()).abs().maxCoeff(), 0.9);
}

}  // namespace
}  // namespace geond
