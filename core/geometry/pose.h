// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>

namespace geond {

// A rigid motion. X_AB is the pose of frame B in frame A: p_AQ = X_AB * p_BQ, X_AC = X_AB * X_BC (letters meet).
class Pose {
 public:
  Pose() = default;
  // `rotation` need not be normalised. Throws std::invalid_argument if it is zero or anything is not finite.
  Pose(const Eigen::Quaterniond& rotation, const Eigen::Vector3d& translation);
  // `rotation` must be a rotation to 1e-6; it is projected on the nearest one. Throws std::invalid_argument if it is not.
  Pose(const Eigen::Matrix3d& rotation, const Eigen::Vector3d& translation);
  static Pose Translation(const Eigen::Vector3d& translation);
  // Rotation by `angle` (rad, right-handed) about the unit `axis` through the origin.
  static Pose Rotation(const Eigen::Vector3d& axis, double angle);

  const Eigen::Quaterniond& rotation() const { return rotation_; }   // unit
  const Eigen::Vector3d& translation() const { return translation_; }  // m
  Eigen::Matrix3d matrix() const { return rotation_.toRotationMatrix(); }

  Eigen::Vector3d operator*(const Eigen::Vector3d& p) const { return rotation_ * p + translation_; }
  Pose operator*(const Pose& other) const;
  // Turns a direction (a normal, an axis) without moving it.
  Eigen::Vector3d Rotate(const Eigen::Vector3d& direction) const { return rotation_ * direction; }

 private:
  Eigen::Quaterniond rotation_ = Eigen::Quaterniond::Identity();
  Eigen::Vector3d translation_ = Eigen::Vector3d::Zero();
};

// X_BA of X_AB.
Pose Inverse(const Pose& pose);

}  // namespace geond
