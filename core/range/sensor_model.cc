// SPDX-License-Identifier: Apache-2.0
#include "core/range/sensor_model.h"

namespace geond {

Eigen::Vector3d Unproject(const SensorModel& sensor, double column, double row, double depth) {
  const double scale = sensor.projection == SensorModel::Projection::kPerspective ? depth : 1.0;
  return {(column - sensor.center_u) / sensor.focal_u * scale, (row - sensor.center_v) / sensor.focal_v * scale, depth};
}

Eigen::Vector3d RayDirection(const SensorModel& sensor, double column, double row) {
  if (sensor.projection == SensorModel::Projection::kOrthographic) return Eigen::Vector3d::UnitZ();
  return Unproject(sensor, column, row, 1.0).normalized();
}

std::optional<Eigen::Vector2d> Project(const SensorModel& sensor, const Eigen::Vector3d& p_S) {
  const bool perspective = sensor.projection == SensorModel::Projection::kPerspective;
  if (perspective && !(p_S.z() > 0.0)) return std::nullopt;
  const double scale = perspective ? 1.0 / p_S.z() : 1.0;
  return Eigen::Vector2d(sensor.focal_u * p_S.x() * scale + sensor.center_u,
                         sensor.focal_v * p_S.y() * scale + sensor.center_v);
}

}  // namespace geond
