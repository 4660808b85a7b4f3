// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include <Eigen/Core>

#include "core/geometry/pose.h"

namespace geond::calib {

// How far poses may lie from the measured ones: standard deviations.
struct PosePrior {
  double rotation = 0.017;      // rad
  double translation = 0.001;   // m, of the object's middle
  double angle = 0.0009;        // rad, of a table angle
};

// The poses of all views as functions of a few parameters, zero at the measured ones. A motion of a view is (rotation times
// `length`, translation) about a point of the table's axis, in T, in metres; each parameter is a length too.
class PoseModel {
 public:
  // Six parameters a view.
  static PoseModel Free(const std::vector<Pose>& X_TS, const Eigen::Vector3d& center_T, double length,
                        const PosePrior& prior);
  // One pose of the sensor against the table's axis for all (6), and the error of each table angle (one a view):
  // X_TS = Rz(-(angle + error)) * X_S0, with X_S0 the mean of what the measured poses say. `center_T` lies on the axis.
  static PoseModel Turntable(const std::vector<Pose>& X_TS, const std::vector<double>& table_angles,
                             const Eigen::Vector3d& center_T, double length, const PosePrior& prior);

  const std::vector<Pose>& X_TS() const { return X_TS_; }         // at the present parameters
  const Eigen::VectorXd& parameters() const { return values_; }
  const Eigen::VectorXd& deviations() const { return sigma_; }    // prior standard deviation of each parameter
  // Change of the motions of all views (6 a view) with the parameters, at the present ones.
  Eigen::MatrixXd Jacobian() const;
  void Set(const Eigen::VectorXd& parameters);                     // moves the poses
  // Root mean square distance (same units as a motion over its prior) of the measured poses from the model's start.
  double misfit() const { return misfit_; }
  bool turntable() const { return turntable_; }
  // The point that motions are counted about: the given one, or its foot on the table's axis.
  const Eigen::Vector3d& center_T() const { return center_T_; }
  // Change of the sensor's pose against the axis (turntable only): rotation (rad) and translation (m, at the centre).
  Eigen::Matrix<double, 6, 1> SensorCorrection() const;

 private:
  void Update();
  bool turntable_ = false;
  double length_ = 1.0;
  double misfit_ = 0.0;
  Eigen::Vector3d center_T_ = Eigen::Vector3d::Zero();
  std::vector<double> angles_;
  std::vector<Pose> X_start_;   // a view (free), or the one sensor pose (turntable)
  std::vector<Pose> X_TS_;
  Eigen::VectorXd values_, sigma_;
};

// The motion of pose `to` against `from` about a point: (rotation vector times length, translation of the point).
Eigen::Matrix<double, 6, 1> MotionBetween(const Pose& from, const Pose& to, const Eigen::Vector3d& center, double length);
// `from` moved so.
Pose Moved(const Pose& from, const Eigen::Matrix<double, 6, 1>& motion, const Eigen::Vector3d& center, double length);

}  // namespace geond::calib
