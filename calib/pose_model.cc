// SPDX-License-Identifier: Apache-2.0
#include "calib/pose_model.h"

#include <cmath>

namespace geond::calib {
namespace {

Eigen::Vector3d RotationVector(const Eigen::Quaterniond& rotation) {
  const Eigen::AngleAxisd turn(rotation);
  double angle = turn.angle();
  if (angle > M_PI) angle -= 2.0 * M_PI;
  return angle * turn.axis();
}

Pose TurnZ(double angle) { return Pose::Rotation(Eigen::Vector3d::UnitZ(), angle); }

Eigen::MatrixXd SkewOf(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

// d(exp(w+d) exp(w)^-1)/dd, the left Jacobian of rotations.
Eigen::Matrix3d LeftJacobian(const Eigen::Vector3d& w) {
  const double angle = w.norm();
  const Eigen::Matrix3d K = SkewOf(w);
  if (angle < 1e-6) return Eigen::Matrix3d::Identity() + 0.5 * K;
  return Eigen::Matrix3d::Identity() + (1.0 - std::cos(angle)) / (angle * angle) * K +
         (angle - std::sin(angle)) / (angle * angle * angle) * K * K;
}

// Change of the motion of a pose (against its present place) with the parameters of `Moved`.
Eigen::Matrix<double, 6, 6> MotionJacobian(const Eigen::Matrix<double, 6, 1>& motion, double length) {
  // The moved pose turns about the point center + t, a motion is counted about the center: t changes by -(J d) x t.
  Eigen::Matrix<double, 6, 6> J = Eigen::Matrix<double, 6, 6>::Identity();
  const Eigen::Matrix3d L = LeftJacobian(motion.head<3>() / length);
  J.topLeftCorner<3, 3>() = L;
  J.bottomLeftCorner<3, 3>() = SkewOf(motion.tail<3>()) * L / length;
  return J;
}

}  // namespace

Eigen::Matrix<double, 6, 1> MotionBetween(const Pose& from, const Pose& to, const Eigen::Vector3d& center,
                                          double length) {
  const Pose change = to * Inverse(from);
  Eigen::Matrix<double, 6, 1> motion;
  motion << length * RotationVector(change.rotation()), change * center - center;
  return motion;
}

Pose Moved(const Pose& from, const Eigen::Matrix<double, 6, 1>& motion, const Eigen::Vector3d& center, double length) {
  const Eigen::Vector3d w = motion.head<3>() / length;
  const double angle = w.norm();
  const Pose turn = angle > 0.0 ? Pose::Rotation(w / angle, angle) : Pose();
  return Pose::Translation(center + motion.tail<3>()) * turn * Pose::Translation(-center) * from;
}

PoseModel PoseModel::Free(const std::vector<Pose>& X_TS, const Eigen::Vector3d& center_T, double length,
                          const PosePrior& prior) {
  PoseModel model;
  model.length_ = length;
  model.center_T_ = center_T;
  model.X_start_ = X_TS;
  const Eigen::Index n = static_cast<Eigen::Index>(X_TS.size());
  model.values_ = Eigen::VectorXd::Zero(6 * n);
  model.sigma_.resize(6 * n);
  for (Eigen::Index i = 0; i < n; ++i) {
    model.sigma_.segment<3>(6 * i).setConstant(prior.rotation * length);
    model.sigma_.segment<3>(6 * i + 3).setConstant(prior.translation);
  }
  model.Update();
  return model;
}

PoseModel PoseModel::Turntable(const std::vector<Pose>& X_TS, const std::vector<double>& table_angles,
                               const Eigen::Vector3d& center_T, double length, const PosePrior& prior) {
  PoseModel model;
  model.turntable_ = true;
  model.length_ = length;
  model.center_T_ = {0.0, 0.0, center_T.z()};
  model.angles_ = table_angles;
  const Eigen::Index n = static_cast<Eigen::Index>(X_TS.size());
  // The mean of the sensor's pose at angle 0 over the views, by three steps of averaging motions.
  Pose X_S0 = TurnZ(table_angles[0]) * X_TS[0];
  for (int step = 0; step < 3; ++step) {
    Eigen::Matrix<double, 6, 1> mean = Eigen::Matrix<double, 6, 1>::Zero();
    for (Eigen::Index i = 0; i < n; ++i) {
      mean += MotionBetween(X_S0, TurnZ(table_angles[i]) * X_TS[i], model.center_T_, length) / static_cast<double>(n);
    }
    X_S0 = Moved(X_S0, mean, model.center_T_, length);
  }
  double squares = 0.0;
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto off = MotionBetween(X_S0, TurnZ(table_angles[i]) * X_TS[i], model.center_T_, length);
    squares += off.head<3>().squaredNorm() / std::pow(prior.rotation * length, 2) +
               off.tail<3>().squaredNorm() / std::pow(prior.translation, 2);
  }
  model.misfit_ = std::sqrt(squares / (6.0 * static_cast<double>(n)));
  model.X_start_ = {X_S0};
  model.values_ = Eigen::VectorXd::Zero(6 + n);
  model.sigma_.resize(6 + n);
  model.sigma_.head<3>().setConstant(prior.rotation * length);
  model.sigma_.segment<3>(3).setConstant(prior.translation);
  model.sigma_.tail(n).setConstant(prior.angle * length);
  model.Update();
  return model;
}

void PoseModel::Set(const Eigen::VectorXd& parameters) {
  values_ = parameters;
  Update();
}

void PoseModel::Update() {
  X_TS_.clear();
  if (!turntable_) {
    for (std::size_t i = 0; i < X_start_.size(); ++i) {
      X_TS_.push_back(Moved(X_start_[i], values_.segment<6>(6 * static_cast<Eigen::Index>(i)), center_T_, length_));
    }
    return;
  }
  const Pose X_S0 = Moved(X_start_[0], values_.head<6>(), center_T_, length_);
  for (std::size_t i = 0; i < angles_.size(); ++i) {
    X_TS_.push_back(TurnZ(-angles_[i] - values_[6 + static_cast<Eigen::Index>(i)] / length_) * X_S0);
  }
}

Eigen::MatrixXd PoseModel::Jacobian() const {
  const Eigen::Index n = static_cast<Eigen::Index>(X_TS_.size());
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(6 * n, values_.size());
  for (Eigen::Index i = 0; i < n; ++i) {
    if (!turntable_) {
      J.block<6, 6>(6 * i, 6 * i) = MotionJacobian(values_.segment<6>(6 * i), length_);
      continue;
    }
    const double angle = -angles_[i] - values_[6 + i] / length_;
    const Eigen::Matrix3d turn = Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    Eigen::Matrix<double, 6, 6> both = Eigen::Matrix<double, 6, 6>::Zero();
    both.topLeftCorner<3, 3>() = turn;
    both.bottomRightCorner<3, 3>() = turn;
    J.block<6, 6>(6 * i, 0) = both * MotionJacobian(values_.head<6>(), length_);
    J(6 * i + 2, 6 + i) = -1.0;
  }
  return J;
}

Eigen::Matrix<double, 6, 1> PoseModel::SensorCorrection() const {
  Eigen::Matrix<double, 6, 1> correction = Eigen::Matrix<double, 6, 1>::Zero();
  if (turntable_) correction << values_.head<3>() / length_, values_.segment<3>(3);
  return correction;
}

}  // namespace geond::calib
