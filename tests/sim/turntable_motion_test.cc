// SPDX-License-Identifier: Apache-2.0
#include "sim/turntable_motion.h"

#include <cmath>

#include <gtest/gtest.h>

namespace geond::sim {
namespace {

using std::chrono::nanoseconds;
nanoseconds Seconds(double s) { return nanoseconds(static_cast<std::int64_t>(std::llround(s * 1e9))); }

// A trapezoid: d/v + v/a; a triangle where the speed is never reached: 2 sqrt(d/a).
TEST(TurntableMotion, ArrivesInTheTimeOfATrapezoid) {
  TurntableOptions options;
  options.max_speed = 0.5;
  options.acceleration = 2.0;
  options.backlash = 0.0;
  EXPECT_DOUBLE_EQ(TurntableMotion::Duration(options, 1.0), 1.0 / 0.5 + 0.5 / 2.0);
  EXPECT_DOUBLE_EQ(TurntableMotion::Duration(options, -0.02), 2.0 * std::sqrt(0.01));
  for (const double angle : {1.0, -1.0, 0.02, -3.0}) {
    const double duration = TurntableMotion::Duration(options, angle);
    TurntableMotion early(options, 0.2), fine(options, 0.2);
    early.MoveTo(0.2 + angle, Seconds(0));
    early.Update(Seconds(duration - 1e-4));
    EXPECT_TRUE(early.moving());
    early.Update(Seconds(duration + 1e-6));
    EXPECT_FALSE(early.moving());
    EXPECT_DOUBLE_EQ(early.motor_angle(), 0.2 + angle);
    // In small steps the same way is gone, and the speed never exceeds its limits.
    fine.MoveTo(0.2 + angle, Seconds(0));
    double last_speed = 0.0;
    for (double t = 0.0; t < duration + 0.01; t += 0.001) {
      fine.Update(Seconds(t));
      EXPECT_LE(std::abs(fine.speed()), 0.5 + 1e-9);
      EXPECT_LE(std::abs(fine.speed() - last_speed), 2.0 * 0.001 + 1e-6);
      last_speed = fine.speed();
    }
    EXPECT_FALSE(fine.moving());
    EXPECT_DOUBLE_EQ(fine.motor_angle(), 0.2 + angle);
  }
}

TEST(TurntableMotion, StopsInTheBrakingDistance) {
  TurntableOptions options;
  options.max_speed = 0.5;
  options.acceleration = 2.0;
  TurntableMotion motion(options);
  motion.MoveTo(3.0, Seconds(0));
  motion.Update(Seconds(1));
  const double at = motion.motor_angle();
  EXPECT_DOUBLE_EQ(motion.speed(), 0.5);
  motion.Stop(Seconds(1));
  motion.Update(Seconds(1.2501));
  EXPECT_FALSE(motion.moving());
  EXPECT_NEAR(motion.motor_angle() - at, 0.5 * 0.5 / (2.0 * 2.0), 1e-9);
}

TEST(TurntableMotion, ANewTargetBehindIsReachedByTurningBack) {
  TurntableOptions options;
  TurntableMotion motion(options);
  motion.MoveTo(3.0, Seconds(0));
  motion.Update(Seconds(1));
  motion.MoveTo(-1.0, Seconds(1));
  motion.Update(Seconds(20));
  EXPECT_FALSE(motion.moving());
  EXPECT_DOUBLE_EQ(motion.motor_angle(), -1.0);
}

TEST(TurntableMotion, TheTableLagsByHalfTheBacklashEachWay) {
  TurntableOptions options;
  options.backlash = 0.01;
  TurntableMotion motion(options);
  motion.MoveTo(1.0, Seconds(0));
  motion.Update(Seconds(100));
  EXPECT_NEAR(motion.table_angle(), 1.0 - 0.005, 1e-12);
  motion.MoveTo(0.996, Seconds(100));  // less than the play: the table stays
  motion.Update(Seconds(200));
  EXPECT_NEAR(motion.table_angle(), 1.0 - 0.005, 1e-12);
  motion.MoveTo(0.5, Seconds(200));
  motion.Update(Seconds(300));
  EXPECT_NEAR(motion.table_angle(), 0.5 + 0.005, 1e-12);
}

TEST(TurntableMotion, TimeDoesNotGoBack) {
  TurntableMotion motion(TurntableOptions{});
  motion.Update(Seconds(2));
  EXPECT_THROW(motion.Update(Seconds(1)), std::invalid_argument);
}

}  // namespace
}  // namespace geond::sim
