// SPDX-License-Identifier: Apache-2.0
#include "core/geometry/pose.h"

#include <stdexcept>

namespace geond {

Pose::Pose(const Eigen::Quaterniond& rotation, const Eigen::Vector3d& translation) : translation_(translation) {
  const double norm = rotation.norm();
  if (!(norm > 1e-12) || !rotation.coeffs().allFinite() || !translation.allFinite()) {
    throw std::invalid_argument("Pose: the rotation is zero or a value is not finite");
  }
  rotation_ = Eigen::Quaterniond(rotation.coeffs() / norm);
}

Pose::Pose(const Eigen::Matrix3d& rotation, const Eigen::Vector3d& translation) : translation_(translation) {
  if (!rotation.allFinite() || !translation.allFinite() ||
      (rotation * rotation.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() > 1e-6 ||
      rotation.determinant() < 0) {
    throw std::invalid_argument("Pose: the matrix is no rotation");
  }
  rotation_ = Eigen::Quaterniond(rotation).normalized();
}

Pose Pose::Translation(const Eigen::Vector3d& translation) { return {Eigen::Quaterniond::Identity(), translation}; }

Pose Pose::Rotation(const Eigen::Vector3d& axis, double angle) {
  return {Eigen::Quaterniond(Eigen::AngleAxisd(angle, axis.normalized())), Eigen::Vector3d::Zero()};
}

Pose Pose::operator*(const Pose& other) const {
  Pose product;
  product.rotation_ = (rotation_ * other.rotation_).normalized();
  product.translation_ = *this * other.translation_;
  return product;
}

Pose Inverse(const Pose& pose) {
  const Eigen::Quaterniond rotation = pose.rotation().conjugate();
  return {rotation, -(rotation * pose.translation())};
}

}  // namespace geond
