// SPDX-License-Identifier: Apache-2.0
#include "daemon/robot/orientation.h"

#include <cmath>

namespace geond::daemon {

Eigen::Vector3d ToRotationVector(const Eigen::Quaterniond& rotation) {
  Eigen::Quaterniond q = rotation.normalized();
  if (q.w() < 0) q.coeffs() = -q.coeffs();
  const double sine = q.vec().norm();
  if (sine < 1e-150) return Eigen::Vector3d::Zero();
  return q.vec() * (2.0 * std::atan2(sine, q.w()) / sine);
}

Eigen::Quaterniond FromRotationVector(const Eigen::Vector3d& vector) {
  const double angle = vector.norm();
  if (angle == 0.0) return Eigen::Quaterniond::Identity();
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle, vector / angle));
}

Eigen::Vector3d ToYawPitchRoll(const Eigen::Quaterniond& rotation) {
  const Eigen::Matrix3d r = rotation.normalized().toRotationMatrix();
  const double cosine = std::hypot(r(0, 0), r(1, 0));
  const double pitch = std::atan2(-r(2, 0), cosine);
  // Near the pole yaw and roll turn about the same line: all of it is given to the yaw.
  if (cosine < 1e-8) return {std::atan2(-r(0, 1), r(1, 1)), pitch, 0.0};
  return {std::atan2(r(1, 0), r(0, 0)), pitch, std::atan2(r(2, 1), r(2, 2))};
}

Eigen::Quaterniond FromYawPitchRoll(const Eigen::Vector3d& yaw_pitch_roll) {
  return Eigen::AngleAxisd(yaw_pitch_roll[0], Eigen::Vector3d::UnitZ()) *
         Eigen::AngleAxisd(yaw_pitch_roll[1], Eigen::Vector3d::UnitY()) *
         Eigen::AngleAxisd(yaw_pitch_roll[2], Eigen::Vector3d::UnitX());
}

}  // namespace geond::daemon
