// SPDX-License-Identifier: Apache-2.0
#include "core/range/sensor_model.h"

#include <gtest/gtest.h>

namespace geond {
namespace {

SensorModel Sensor(SensorModel::Projection projection) {
  SensorModel sensor;
  sensor.projection = projection;
  sensor.columns = 320;
  sensor.rows = 200;
  sensor.focal_u = 521.0;
  sensor.focal_v = -517.5;
  sensor.center_u = 158.25;
  sensor.center_v = 101.5;
  return sensor;
}

TEST(SensorModel, ProjectUndoesUnproject) {
  for (auto projection : {SensorModel::Projection::kPerspective, SensorModel::Projection::kOrthographic}) {
    const SensorModel sensor = Sensor(projection);
    for (double u : {-3.0, 0.0, 17.25, 319.0}) {
      for (double v : {0.0, 101.5, 250.0}) {
        for (double z : {0.1, 0.45, 12.0}) {
          const auto pixel = Project(sensor, Unproject(sensor, u, v, z));
          ASSERT_TRUE(pixel.has_value());
          EXPECT_NEAR(pixel->x(), u, 1e-10);
          EXPECT_NEAR(pixel->y(), v, 1e-10);
          EXPECT_EQ(Unproject(sensor, u, v, z).z(), z);
        }
      }
    }
  }
}

TEST(SensorModel, PointsOfAPixelLieOnItsRay) {
  for (auto projection : {SensorModel::Projection::kPerspective, SensorModel::Projection::kOrthographic}) {
    const SensorModel sensor = Sensor(projection);
    const Eigen::Vector3d near = Unproject(sensor, 40, 7, 0.2), far = Unproject(sensor, 40, 7, 1.7);
    EXPECT_NEAR((far - near).normalized().dot(RayDirection(sensor, 40, 7)), 1.0, 1e-14);
    EXPECT_NEAR(RayDirection(sensor, 40, 7).norm(), 1.0, 1e-15);
  }
}

TEST(SensorModel, SeesNothingBehindAPerspectiveSensor) {
  EXPECT_FALSE(Project(Sensor(SensorModel::Projection::kPerspective), {0.1, 0.1, -1.0}).has_value());
  EXPECT_FALSE(Project(Sensor(SensorModel::Projection::kPerspective), {0.1, 0.1, 0.0}).has_value());
  EXPECT_TRUE(Project(Sensor(SensorModel::Projection::kOrthographic), {0.1, 0.1, -1.0}).has_value());
}

}  // namespace
}  // namespace geond
