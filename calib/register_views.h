// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stop_token>
#include <vector>

#include "core/base/progress.h"
#include "core/base/solve_summary.h"
#include "core/range/range_view.h"

namespace geond::calib {

struct RegisterOptions {
  enum class Model { kAuto, kTurntable, kFree, kNone };
  Model model = Model::kAuto;        // one axis for all views with small angle errors, or six degrees a view with priors
  double max_distance = 0.010;       // m: correspondences further apart do not count (first round; shrinks)
  double prior_rotation = 0.017;     // rad, standard deviation of the measured poses
  double prior_translation = 0.001;  // m
  int rounds = 12;                   // of correspondence and solve
  int samples = 3000;                // points a pair of views
  int threads = 0;
};

struct RegistrationResult {
  std::vector<Pose> X_TS;            // refined, a view
  RegisterOptions::Model model = RegisterOptions::Model::kNone;  // the one used
  double rms_before = 0.0;           // along normals between overlapping views, m
  double rms_after = 0.0;
  std::vector<std::string> notes;    // directions the shape does not show, views that do not overlap, ...
  SolveSummary summary;
};

// Refines the poses of all views together (point to plane, robust; Ceres), starting from X_TS_measured. Directions that the
// shape does not constrain stay as measured and are noted. Throws Cancelled.
RegistrationResult RegisterViews(const std::vector<RangeView>& views, const RegisterOptions& options = {},
                                 std::stop_token stop = {}, const StepObserver& on_step = {});

}  // namespace geond::calib
