// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <stop_token>
#include <utility>
#include <vector>

#include "calib/pair_terms.h"
#include "calib/pose_model.h"
#include "calib/register_views.h"

namespace geond::calib {

// What a run over all rounds left: the model at its end, what it rests on, and how well the views agree.
struct Refinement {
  PoseModel model;
  std::vector<PairTerm> terms;      // of the last round, without their lists
  Eigen::MatrixXd H, noise;         // 6 a view, sums over the terms
  Eigen::MatrixXd shown;            // directions of the parameters (over their deviations) that were moved
  Eigen::MatrixXd by_creases;       // of the shown directions those that only creases show; one axis for all views alone
  double scale = 0.0;               // m, robust standard deviation along normals
  double last_step = 0.0;           // m, largest motion of the last round
  int rounds = 0;
  bool converged = false;
};

// Alternates correspondences and solves from coarse (few samples, far) to fine. `fine_only`: starts at the fine end.
Refinement RefinePoses(const std::vector<ViewPoints>& views, PoseModel model, double length,
                       const RegisterOptions& options, bool fine_only, std::stop_token stop,
                       const std::function<void(int)>& on_round);

// All ordered pairs that meet at these poses, compared.
std::vector<PairTerm> ComparePairs(const std::vector<ViewPoints>& views, const std::vector<Pose>& X_TS,
                                   const std::vector<std::pair<int, int>>& pairs, const Eigen::Vector3d& center_T,
                                   double length, const PairOptions& options, int threads);

// Ordered pairs of views with at least `share` of a's points (a coarse sample) met by b.
std::vector<std::pair<int, int>> FindOverlaps(const std::vector<ViewPoints>& views, const std::vector<Pose>& X_TS,
                                              double max_distance, double share, int threads);

// Median absolute distance times 1.4826.
double RobustScale(const std::vector<PairTerm>& terms);

}  // namespace geond::calib
