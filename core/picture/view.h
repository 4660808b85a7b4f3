// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>

#include "core/picture/scene.h"

namespace geond {

// World to eye: x right, y up, z towards the eye.
Eigen::Matrix3d ViewRotation(double azimuth, double elevation);

// The camera over a raster of pixels: world to eye to pixel and back.
class View {
 public:
  View(const Camera& camera, int columns, int rows);
  int columns() const { return columns_; }
  int rows() const { return rows_; }
  double focal() const { return focal_; }      // pixels
  double nearest() const { return nearest_; }  // m: what is nearer to the eye is not drawn
  const Eigen::Matrix3d& rotation() const { return rotation_; }

  // (column, row, depth along the line of sight, m).
  Eigen::Vector3d Project(const Eigen::Vector3d& world) const;
  Eigen::Vector3d ToEye(const Eigen::Vector3d& world) const { return rotation_ * (world - eye_); }  // depth is -z
  Eigen::Vector3d EyePoint(double column, double row, double depth) const;  // in the eye's frame
  Eigen::Vector3d ToWorld(const Eigen::Vector3d& in_eye) const { return rotation_.transpose() * in_eye + eye_; }
  const Eigen::Vector3d& eye() const { return eye_; }

 private:
  int columns_, rows_;
  double focal_, nearest_;
  Eigen::Matrix3d rotation_;
  Eigen::Vector3d eye_;
};

}  // namespace geond
