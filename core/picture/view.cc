// SPDX-License-Identifier: Apache-2.0
#include "core/picture/view.h"

#include <algorithm>
#include <cmath>

namespace geond {

Eigen::Matrix3d ViewRotation(double azimuth, double elevation) {
  const Eigen::Vector3d back(std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
                             std::sin(elevation));
  const Eigen::Vector3d right(-std::sin(azimuth), std::cos(azimuth), 0.0);
  Eigen::Matrix3d rotation;
  rotation << right.transpose(), back.cross(right).transpose(), back.transpose();
  return rotation;
}

View::View(const Camera& camera, int columns, int rows)
    : columns_(columns),
      rows_(rows),
      focal_(0.5 * std::min(columns, rows) / std::tan(0.5 * camera.field_of_view)),
      nearest_(0.02 * camera.distance),
      rotation_(ViewRotation(camera.azimuth, camera.elevation)),
      eye_(camera.target + camera.distance * rotation_.row(2).transpose()) {}

Eigen::Vector3d View::Project(const Eigen::Vector3d& world) const {
  const Eigen::Vector3d p = ToEye(world);
  const double depth = -p.z();
  if (depth <= 0.0) return {0.0, 0.0, depth};
  return {0.5 * columns_ + focal_ * p.x() / depth, 0.5 * rows_ - focal_ * p.y() / depth, depth};
}

Eigen::Vector3d View::EyePoint(double column, double row, double depth) const {
  return {(column - 0.5 * columns_) / focal_ * depth, -(row - 0.5 * rows_) / focal_ * depth, -depth};
}

}  // namespace geond
