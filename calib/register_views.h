// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stop_token>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "core/base/progress.h"
#include "core/base/solve_summary.h"
#include "core/range/range_view.h"

namespace geond::calib {

struct RegisterOptions {
  enum class Model { kAuto, kTurntable, kFree, kNone };
  Model model = Model::kAuto;        // one axis for all views with small angle errors, or six degrees a view with priors
  double max_distance = 0.010;       // m: correspondences further apart do not count (first round; shrinks)
  double prior_rotation = 0.017;     // rad, standard deviation of the measured poses
  double prior_translation = 0.001;  // m, of the object's middle
  double prior_angle = 0.0009;       // rad, standard deviation of a table angle
  int rounds = 12;                   // of correspondence and solve
  int samples = 8000;                // points a pair of views at most, in the last rounds
  int threads = 0;
};

// How much of view `a` is also seen by view `b`, and how well they agree there.
struct ViewOverlap {
  int a = 0, b = 0;
  double share = 0.0;  // of a's points
  double rms = 0.0;    // along normals, m
};

struct RegistrationResult {
  std::vector<Pose> X_TS;            // refined, a view
  RegisterOptions::Model model = RegisterOptions::Model::kNone;  // the one used
  double rms_before = 0.0;           // along normals between overlapping views, m
  double rms_after = 0.0;
  std::vector<std::string> notes;    // directions the shape does not show, views that do not overlap, ...
  SolveSummary summary;
  std::vector<ViewOverlap> overlaps;  // of every ordered pair that meets, at the refined poses
  // A view: covariance of (rotation, rad; translation of the object's middle, m) in T, from data and priors; directions that
  // the shape does not show carry the prior alone.
  std::vector<Eigen::Matrix<double, 6, 6>> covariance;
  Eigen::Vector3d center_T = Eigen::Vector3d::Zero();  // the object's middle, to which the covariances refer
  // Turntable model: how far the sensor stood from where the calibration has it, against the axis (rad; m at center_T's
  // height on the axis), and the error of each table angle (rad). A drift of the calibration shows here.
  Eigen::Matrix<double, 6, 1> sensor_correction = Eigen::Matrix<double, 6, 1>::Zero();
  Eigen::Matrix<double, 6, 6> sensor_covariance = Eigen::Matrix<double, 6, 6>::Zero();
  std::vector<double> angle_errors;
};

// Refines the poses of all views together (symmetric point to plane, robust, correspondences by projection into the other
// range images, found again each round), starting from X_TS_measured. Directions that the shape does not constrain stay as
// measured and are noted. kAuto takes the turntable's model unless the free one fits clearly better. The same input gives
// the same bits for any number of threads. Throws Cancelled; std::invalid_argument if a view's lists have wrong lengths.
RegistrationResult RegisterViews(const std::vector<RangeView>& views, const RegisterOptions& options = {},
                                 std::stop_token stop = {}, const StepObserver& on_step = {});

}  // namespace geond::calib
