// SPDX-License-Identifier: Apache-2.0
// Each round is one linear problem: all returns of a pair of views are condensed to a quadratic form in six numbers, directions
// that the shape does not show are projected out by eigenvalues, and what is left is a dense system of at most six unknowns a
// view. A general solver (Ceres, as the station's calibration uses it) would factor the same matrix, or evaluate every return as
// a residual of its own with automatic derivatives, which takes several times as long; so Eigen's factorisation does it.
#include "calib/pose_refinement.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/SVD>

#include "calib/shown_directions.h"
#include "core/base/parallel.h"

namespace geond::calib {
namespace {

constexpr double kPartners = 8.0;      // views that a view is compared with at full sampling; with more, less of each
constexpr double kLeastScale = 2e-6;  // m: exact data need a scale too

// How one round compares the views.
struct Level {
  int samples;
  double max_distance;
  double min_cosine;
};

Level LevelOf(double progress, double scale, double pitch, const RegisterOptions& options) {
  const double near = std::min(options.max_distance, 6.0 * scale + 3.0 * pitch);
  if (progress < 0.34) return {std::max(300, options.samples / 8), options.max_distance, 0.5};
  if (progress < 0.6) return {std::max(600, options.samples / 3), 0.5 * (options.max_distance + near), 0.7};
  return {options.samples, near, 0.8};
}

double MedianPitch(const std::vector<ViewPoints>& views) {
  std::vector<float> pitches;
  for (const auto& ready : views) {
    const SensorModel& sensor = ready.view->sensor;
    for (std::size_t i = 0; i < ready.points_S.size(); i += 50) {
      const double scale =
          sensor.projection == SensorModel::Projection::kPerspective ? ready.points_S[i].z() : 1.0;
      pitches.push_back(static_cast<float>(scale / std::min(sensor.focal_u, sensor.focal_v)));
    }
  }
  return Median(pitches);
}

// The sums of one of the terms' matrices over all pairs, for the motions of all views.
Eigen::MatrixXd Assemble(const std::vector<PairTerm>& terms, Eigen::Index n, Matrix6d PairTerm::* part) {
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(6 * n, 6 * n);
  for (const auto& term : terms) {
    const Eigen::Index at[2] = {6 * term.a, 6 * term.b};
    for (int r = 0; r < 2; ++r) {
      for (int c = 0; c < 2; ++c) sum.block<6, 6>(at[r], at[c]) += (r == c ? 1.0 : -1.0) * (term.*part);
    }
  }
  return sum;
}

Eigen::VectorXd AssembleGradient(const std::vector<PairTerm>& terms, Eigen::Index n) {
  Eigen::VectorXd g = Eigen::VectorXd::Zero(6 * n);
  for (const auto& term : terms) {
    g.segment<6>(6 * term.a) += term.g;
    g.segment<6>(6 * term.b) -= term.g;
  }
  return g;
}

// Directions of one space, given by orthonormal columns, that lie almost wholly in the other.
Eigen::MatrixXd Meet(const Eigen::MatrixXd& one, const Eigen::MatrixXd& other) {
  if (one.cols() == 0 || other.cols() == 0) return Eigen::MatrixXd(one.rows(), 0);
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(other.transpose() * one, Eigen::ComputeThinV);
  Eigen::Index inside = 0;
  while (inside < svd.singularValues().size() && svd.singularValues()[inside] > 0.9) ++inside;
  return one * svd.matrixV().leftCols(inside);
}

}  // namespace

double RobustScale(const std::vector<PairTerm>& terms) {
  std::vector<float> all;
  for (const auto& term : terms) all.insert(all.end(), term.distances.begin(), term.distances.end());
  return 1.4826 * Median(all);
}

std::vector<PairTerm> ComparePairs(const std::vector<ViewPoints>& views, const std::vector<Pose>& X_TS,
                                   const std::vector<std::pair<int, int>>& pairs, const Eigen::Vector3d& center_T,
                                   double length, const PairOptions& options, int threads) {
  std::vector<PairTerm> terms(pairs.size());
  ParallelFor(static_cast<std::ptrdiff_t>(pairs.size()), threads, 1, [&](std::ptrdiff_t k) {
    terms[k] = ComparePair(views, X_TS, pairs[k].first, pairs[k].second, center_T, length, options);
  });
  return terms;
}

std::vector<std::pair<int, int>> FindOverlaps(const std::vector<ViewPoints>& views, const std::vector<Pose>& X_TS,
                                              double max_distance, double share, int threads) {
  std::vector<std::pair<int, int>> all;
  const int n = static_cast<int>(views.size());
  for (int a = 0; a < n; ++a) {
    for (int b = 0; b < n; ++b) {
      // Seen from opposite sides there is no common surface.
      if (a != b && !views[a].points_S.empty() && !views[b].points_S.empty()) all.emplace_back(a, b);
    }
  }
  PairOptions options;
  options.samples = 250;
  options.max_distance = max_distance;
  options.min_cosine = 0.5;
  const auto terms = ComparePairs(views, X_TS, all, Eigen::Vector3d::Zero(), 1.0, options, threads);
  std::vector<std::pair<int, int>> pairs;
  for (std::size_t k = 0; k < all.size(); ++k) {
    const double asked = std::min<double>(options.samples, static_cast<double>(views[all[k].first].points_S.size()));
    if (terms[k].points >= share * asked && terms[k].points >= 6) pairs.push_back(all[k]);
  }
  return pairs;
}

Refinement RefinePoses(const std::vector<ViewPoints>& views, PoseModel model, double length,
                       const RegisterOptions& options, bool fine_only, std::stop_token stop,
                       const std::function<void(int)>& on_round) {
  const Eigen::Vector3d center_T = model.center_T();
  Refinement run{std::move(model), {}, {}, {}, {}, {}, 0.0, 0.0, 0, false};
  const Eigen::Index n = static_cast<Eigen::Index>(views.size());
  const double pitch = MedianPitch(views);
  double points = 0.0;  // of the largest view
  for (const auto& view : views) points = std::max(points, static_cast<double>(view.points_S.size()));
  const int rounds = std::max(1, options.rounds);
  const int first = fine_only ? static_cast<int>(std::ceil(0.6 * rounds)) : 0;
  std::vector<std::pair<int, int>> pairs;
  double searched = 0.0;  // the distance the pairs were last searched with
  run.scale = options.max_distance / 3.0;

  for (int round = first; round < rounds; ++round) {
    ThrowIfStopped(stop);
    const double progress = static_cast<double>(round) / rounds;
    const Level level = LevelOf(progress, round == first ? options.max_distance : run.scale, pitch, options);
    if (searched != level.max_distance && (round == first || searched > 1.5 * level.max_distance)) {
      pairs = FindOverlaps(views, run.model.X_TS(), level.max_distance, 0.05, options.threads);
      searched = level.max_distance;
    }
    PairOptions pair_options;
    const double partners = static_cast<double>(pairs.size()) / static_cast<double>(n);
    const auto samples = static_cast<int>(std::min<double>(level.samples, points) * std::min(1.0, kPartners / partners));
    pair_options.samples = samples;
    pair_options.max_distance = level.max_distance;
    pair_options.min_cosine = level.min_cosine;
    if (round == first) {  // only to learn the scale
      pair_options.samples = 300;
      const auto probe = ComparePairs(views, run.model.X_TS(), pairs, center_T, length, pair_options, options.threads);
      run.scale = std::max(kLeastScale, RobustScale(probe));
      pair_options.samples = samples;
    }
    pair_options.scale = run.scale;
    run.terms = ComparePairs(views, run.model.X_TS(), pairs, center_T, length, pair_options, options.threads);
    run.H = Assemble(run.terms, n, &PairTerm::H);
    run.noise = Assemble(run.terms, n, &PairTerm::noise);
    const Eigen::VectorXd g = AssembleGradient(run.terms, n);

    const Eigen::MatrixXd J = run.model.Jacobian();
    const Eigen::VectorXd& sigma = run.model.deviations();
    Eigen::MatrixXd H = J.transpose() * run.H * J;
    const Eigen::MatrixXd noise = J.transpose() * run.noise * J;
    // With all views on one axis the errors at creases even out; a single free view follows them.
    const ShownDirections by_faces =
        FindShownDirections(H - J.transpose() * Assemble(run.terms, n, &PairTerm::H_creases) * J,
                            noise - J.transpose() * Assemble(run.terms, n, &PairTerm::noise_creases) * J, sigma);
    run.shown = by_faces.shown;
    if (run.model.turntable()) {
      run.shown = FindShownDirections(H, noise, sigma).shown;
      run.by_creases = Meet(run.shown, by_faces.hidden);
    }
    // The noise of the normals makes H too large, hence steps too short, where the shape shows little. Half of it is taken
    // off: all would be too much where it is estimated too large, and steps beyond twice the right ones diverge.
    H -= 0.5 * noise;
    // Minimise over the shown directions z, parameters = sigma * shown * z: (step = parameters - present)
    //   1/2 step' H step + g' J step + 1/2 |z|^2
    const Eigen::VectorXd present = run.model.parameters();
    Eigen::VectorXd next = Eigen::VectorXd::Zero(present.size());
    if (run.shown.cols() > 0) {
      const Eigen::MatrixXd V = sigma.asDiagonal() * run.shown;
      Eigen::MatrixXd A = V.transpose() * H * V;
      A.diagonal().array() += 1.0;
      next = V * A.ldlt().solve(V.transpose() * (H * present - J.transpose() * g));
    }
    run.last_step = (J * (next - present)).cwiseAbs().maxCoeff();
    run.model.Set(next);
    run.scale = std::max(kLeastScale, RobustScale(run.terms));
    run.rounds = round - first + 1;
    on_round(round - first + 1);
    const bool fine = progress >= 0.6;
    if (fine && run.last_step < std::max(1e-8, 0.002 * run.scale)) {
      run.converged = true;
      break;
    }
    if (!fine && run.last_step < 0.05 * run.scale) {  // nothing more to gain at this level
      const double next_level = progress < 0.34 ? 0.34 : 0.6;
      round = std::max(round, static_cast<int>(std::ceil(next_level * rounds)) - 1);
    }
  }
  run.converged = run.converged || run.last_step < 0.05 * run.scale;
  return run;
}

}  // namespace geond::calib
