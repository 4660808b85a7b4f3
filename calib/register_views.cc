// SPDX-License-Identifier: Apache-2.0
#include "calib/register_views.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>
#include <numeric>
#include <stdexcept>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "calib/pose_refinement.h"
#include "core/base/printed.h"
#include "calib/shown_directions.h"

namespace geond::calib {
namespace {

using Model = RegisterOptions::Model;

constexpr double kMaxMisfit = 4.0;        // prior deviations of the measured poses from one axis: more, and there is none
constexpr double kLeastShare = 0.02;      // of the prior's deviations, that free poses may leave the axis by
constexpr double kPointsPerDatum = 16.0;  // points of the range images that make one independent datum of the evidence

void Validate(const std::vector<RangeView>& views) {
  for (const auto& view : views) {
    const std::size_t pixels = static_cast<std::size_t>(view.image.columns) * view.image.rows;
    if (view.image.depth.size() != pixels || view.classes.size() != pixels || view.normals_S.size() != pixels) {
      throw std::invalid_argument("RegisterViews: image, classes and normals of a view differ in length");
    }
  }
}

struct Extent {
  Eigen::Vector3d center_T = Eigen::Vector3d::Zero();
  double length = 1.0;  // root mean square distance of the points from the centre, m
};

Extent ExtentOf(const std::vector<ViewPoints>& views, const std::vector<Pose>& X_TS) {
  Extent extent;
  double squares = 0.0;
  std::size_t n = 0;
  for (std::size_t k = 0; k < views.size(); ++k) {
    for (const auto& p_S : views[k].points_S) {
      const Eigen::Vector3d p_T = X_TS[k] * p_S;
      extent.center_T += p_T;
      squares += p_T.squaredNorm();
      ++n;
    }
  }
  if (n == 0) return extent;
  extent.center_T /= static_cast<double>(n);
  extent.length = std::sqrt(std::max(1e-8, squares / static_cast<double>(n) - extent.center_T.squaredNorm()));
  return extent;
}

struct Agreement {
  std::vector<PairTerm> terms;
  double points = 0.0;
  double rms = 0.0;
  double loss = 0.0;  // mean
};

Agreement Agree(const std::vector<ViewPoints>& views, const std::vector<Pose>& X_TS, const Extent& extent,
                double max_distance, double scale, int samples, int threads) {
  Agreement agreement;
  PairOptions options;
  options.max_distance = max_distance;
  options.scale = scale;
  options.samples = samples;
  const auto pairs = FindOverlaps(views, X_TS, max_distance, 0.02, threads);
  agreement.terms = ComparePairs(views, X_TS, pairs, extent.center_T, extent.length, options, threads);
  double squares = 0.0, loss = 0.0;
  for (const auto& term : agreement.terms) {
    agreement.points += term.points;
    squares += term.squares;
    loss += term.loss;
  }
  if (agreement.points > 0) {
    agreement.rms = std::sqrt(squares / agreement.points);
    agreement.loss = loss / agreement.points;
  }
  return agreement;
}

// Whether six degrees a view explain the data so much better than one axis that their number is worth it (Schwarz's
// criterion on the robust loss at the same scale).
bool FreeIsBetter(const Agreement& axis, const Agreement& free, double more_parameters) {
  const double data = std::min(axis.points, free.points) / kPointsPerDatum;
  if (data < 10.0) return false;
  return data * (axis.loss - free.loss) > more_parameters * std::log(data);
}

// How far free poses left the axis at most, in deviations of the prior, of the directions that the data know well; 1 if these
// are too few. What repeats in several pairs is counted as four.
double MovedShare(const Refinement& run) {
  constexpr double kWell = 500.0, kRepeated = 4.0;
  constexpr int kFew = 6;
  const Eigen::VectorXd& sigma = run.model.deviations();
  const Eigen::MatrixXd J = run.model.Jacobian();
  const Eigen::MatrixXd H = sigma.asDiagonal() * (J.transpose() * run.H * J) * sigma.asDiagonal();
  const Eigen::MatrixXd noise = sigma.asDiagonal() * (J.transpose() * run.noise * J) * sigma.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(H - noise);
  const Eigen::VectorXd moved = eigen.eigenvectors().transpose() * run.model.parameters().cwiseQuotient(sigma);
  double greatest = 0.0;
  int known = 0;
  for (Eigen::Index k = 0; k < moved.size(); ++k) {
    const double information = eigen.eigenvalues()[k];
    const auto direction = eigen.eigenvectors().col(k);
    const double spread = kRepeated * direction.dot(H * direction);  // of the gradient
    if (information <= 0.0 || information * information < kWell * spread) continue;
    greatest = std::max(greatest, std::abs(moved[k]));
    ++known;
  }
  return known < kFew ? 1.0 : greatest;
}

std::vector<std::string> NotesOnOverlap(const std::vector<ViewPoints>& views, const std::vector<PairTerm>& terms) {
  const std::size_t n = views.size();
  std::vector<std::size_t> group(n);
  std::iota(group.begin(), group.end(), 0);
  const auto root = [&](std::size_t i) {
    while (group[i] != i) i = group[i];
    return i;
  };
  for (const auto& term : terms) group[std::max(root(term.a), root(term.b))] = std::min(root(term.a), root(term.b));
  std::vector<std::string> notes;
  for (std::size_t i = 0; i < n; ++i) {
    if (views[i].points_S.empty()) {
      notes.push_back(Printed("view %zu shows nothing of the object; its pose stays as measured", i));
    } else if (root(i) == i && i != root(0)) {
      const auto members = std::count_if(group.begin(), group.end(), [&](std::size_t k) { return root(k) == i; });
      notes.push_back(Printed("view %zu%s overlaps no other view enough; its pose stays as measured: take a view between",
                              i, members > 1 ? " and those joined to it" : ""));
    }
  }
  return notes;
}

// Covariance of each view's motion: what is known of the shown directions, and the prior in the hidden ones.
void SetCovariances(const Refinement& run, const Extent& extent, RegistrationResult& result) {
  const Eigen::MatrixXd J = run.model.Jacobian();
  const Eigen::VectorXd& sigma = run.model.deviations();
  const Eigen::Index n = sigma.size();
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Identity(n, n);
  if (run.shown.cols() > 0) {
    const Eigen::MatrixXd V = sigma.asDiagonal() * run.shown;
    Eigen::MatrixXd A = V.transpose() * (J.transpose() * run.H * J) * V;
    A.diagonal().array() += 1.0;
    const Eigen::MatrixXd known = A.ldlt().solve(Eigen::MatrixXd::Identity(A.rows(), A.cols()));
    covariance += run.shown * (known - Eigen::MatrixXd::Identity(A.rows(), A.cols())) * run.shown.transpose();
  }
  if (run.model.turntable()) {
    result.sensor_covariance =
        sigma.head<6>().asDiagonal() * covariance.topLeftCorner<6, 6>() * sigma.head<6>().asDiagonal();
    result.sensor_covariance.topRows<3>() /= extent.length;
    result.sensor_covariance.leftCols<3>() /= extent.length;
  }
  // From the point that motions are counted about to the object's middle.
  const Eigen::Vector3d arm = (extent.center_T - run.model.center_T()) / extent.length;
  Matrix6d to_middle = Matrix6d::Identity();
  to_middle.bottomLeftCorner<3, 3>() << 0, arm.z(), -arm.y(), -arm.z(), 0, arm.x(), arm.y(), -arm.x(), 0;
  const Eigen::MatrixXd root = J * sigma.asDiagonal();
  for (std::size_t k = 0; k < result.X_TS.size(); ++k) {
    const Eigen::MatrixXd rows = root.middleRows(6 * static_cast<Eigen::Index>(k), 6);
    Matrix6d of_view = to_middle * (rows * covariance * rows.transpose()) * to_middle.transpose();
    of_view.topRows<3>() /= extent.length;
    of_view.leftCols<3>() /= extent.length;
    result.covariance.push_back(of_view);
  }
}

std::vector<std::string> NotesOnShape(const Refinement& run, const Extent& extent, const RegisterOptions& options) {
  Matrix6d H = Matrix6d::Zero(), noise = Matrix6d::Zero();
  for (const auto& term : run.terms) {
    H += term.H;
    noise += term.noise;
  }
  Vector6d sigma;
  sigma << Eigen::Vector3d::Constant(options.prior_rotation * extent.length),
      Eigen::Vector3d::Constant(options.prior_translation);
  return DescribeHiddenMotions(H, noise, sigma, run.model.center_T(), extent.length);
}

// Where the sensor stands against the axis, as far as only edges show it.
std::vector<std::string> NotesOnCreases(const Refinement& run) {
  std::vector<std::string> notes;
  for (Eigen::Index k = 0; k < run.by_creases.cols(); ++k) {
    const Eigen::VectorXd motion = run.model.deviations().cwiseProduct(run.by_creases.col(k));
    const Eigen::Vector3d shift = motion.segment<3>(3);
    if (shift.norm() < 0.7 * motion.norm()) continue;
    Eigen::Index largest;
    shift.cwiseAbs().maxCoeff(&largest);
    const Eigen::Vector3d d = (shift / std::copysign(shift.norm(), shift[largest])).array() + 0.0;
    notes.push_back(Printed("only edges show how far the sensor stands from the axis along (%.2f, %.2f, %.2f): that is uncertain "
                            "by some 0.1 mm; views between would show it", d.x(), d.y(), d.z()));
  }
  return notes;
}

void NoteDrift(const RegisterOptions& options, RegistrationResult& result) {
  const double turn = result.sensor_correction.head<3>().norm(), shift = result.sensor_correction.tail<3>().norm();
  if (turn > options.prior_rotation || shift > 2.0 * options.prior_translation) {
    result.notes.push_back(Printed("the sensor stands %.2f deg and %.2f mm off its calibration against the table's axis: "
                                   "calibrate the station again", turn * 180.0 / std::numbers::pi, shift * 1e3));
  }
}

}  // namespace

RegistrationResult RegisterViews(const std::vector<RangeView>& views, const RegisterOptions& options,
                                 std::stop_token stop, const StepObserver& on_step) {
  Validate(views);
  const auto start = std::chrono::steady_clock::now();
  RegistrationResult result;
  std::vector<ViewPoints> ready;
  std::vector<double> angles;
  for (const auto& view : views) {
    ready.push_back(ReadyForRegistration(view));
    result.X_TS.push_back(view.X_TS_measured);
    angles.push_back(view.table_angle);
  }
  const std::vector<Pose> measured = result.X_TS;
  const Extent extent = ExtentOf(ready, measured);
  result.center_T = extent.center_T;
  const auto finish = [&](bool converged, std::string message) {
    result.summary.converged = converged;
    result.summary.message = std::move(message);
    result.summary.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return result;
  };
  if (options.model == Model::kNone || views.size() < 2) {
    result.rms_before = result.rms_after = Agree(ready, measured, extent, options.max_distance, options.max_distance,
                                                 options.samples, options.threads).rms;
    return finish(true, options.model == Model::kNone ? "poses kept as measured" : "a single view needs no registration");
  }

  const int total = options.rounds;
  const auto on_round = [&](int done) {
    if (on_step) on_step("register", std::min(done, total), total);
  };
  on_round(0);
  const PosePrior prior{options.prior_rotation, options.prior_translation, options.prior_angle};
  const auto refine = [&](PoseModel model, bool fine_only) {
    return RefinePoses(ready, std::move(model), extent.length, options, fine_only, stop, on_round);
  };

  // Free poses start from the axis that explains the measured ones best: directions that the shape does not show are then
  // as good as the mean of all views, not as each single one. How far the well shown directions go from there tells how much
  // to trust the axis in those that the shape hardly shows.
  const auto refine_from_axis = [&](const std::vector<Pose>& X_TS, bool fine_only) {
    const auto from = [&](double share) {
      const PosePrior near{share * prior.rotation, share * prior.translation, prior.angle};
      return PoseModel::Free(X_TS, extent.center_T, extent.length, near);
    };
    Refinement free = refine(from(1.0), fine_only);
    const double share = std::max(kLeastShare, MovedShare(free));
    return share < 0.5 ? refine(from(share), true) : free;
  };
  std::optional<Refinement> run;
  PoseModel turntable = PoseModel::Turntable(measured, angles, extent.center_T, extent.length, prior);
  if (options.model == Model::kTurntable || turntable.misfit() <= kMaxMisfit) {
    run = refine(std::move(turntable), false);
  } else if (options.model == Model::kAuto) {
    result.notes.push_back("the measured poses do not turn about one axis by the table's angles: views refined freely");
  }
  if (!run) {
    run = refine(PoseModel::Free(measured, extent.center_T, extent.length, prior), false);
  } else if (options.model == Model::kFree) {
    run = refine_from_axis(run->model.X_TS(), false);
  } else if (options.model == Model::kAuto) {
    Refinement free = refine_from_axis(run->model.X_TS(), true);
    const double scale = run->scale, reach = std::min(options.max_distance, 10.0 * scale);
    const auto as_axis = Agree(ready, run->model.X_TS(), extent, reach, scale, options.samples, options.threads);
    const auto as_free = Agree(ready, free.model.X_TS(), extent, reach, scale, options.samples, options.threads);
    if (FreeIsBetter(as_axis, as_free, 5.0 * static_cast<double>(views.size()) - 6.0)) {
      result.notes.push_back(Printed("the views do not turn about one axis: refined freely (%.3f mm against %.3f mm)",
                                     as_free.rms * 1e3, as_axis.rms * 1e3));
      run = std::move(free);
    }
  }

  result.X_TS = run->model.X_TS();
  result.model = run->model.turntable() ? Model::kTurntable : Model::kFree;
  if (run->model.turntable()) {
    result.sensor_correction = run->model.SensorCorrection();
    for (std::size_t k = 0; k < views.size(); ++k) {
      result.angle_errors.push_back(run->model.parameters()[6 + static_cast<Eigen::Index>(k)] / extent.length);
    }
  }
  const auto before = Agree(ready, measured, extent, options.max_distance, run->scale, options.samples, options.threads);
  const auto after =
      Agree(ready, result.X_TS, extent, options.max_distance, run->scale, options.samples, options.threads);
  result.rms_before = before.rms;
  result.rms_after = after.rms;
  for (const auto& term : after.terms) {
    const double asked = std::min<double>(options.samples, static_cast<double>(ready[term.a].points_S.size()));
    result.overlaps.push_back({term.a, term.b, term.points / asked, std::sqrt(term.squares / std::max(1, term.points))});
  }
  SetCovariances(*run, extent, result);
  for (auto& note : NotesOnOverlap(ready, after.terms)) result.notes.push_back(std::move(note));
  for (auto& note : NotesOnShape(*run, extent, options)) result.notes.push_back(std::move(note));
  for (auto& note : NotesOnCreases(*run)) result.notes.push_back(std::move(note));
  NoteDrift(options, result);
  result.summary.iterations = run->rounds;
  result.summary.residual = run->last_step / extent.length;
  on_round(total);
  return finish(run->converged, run->converged ? "converged" : "the last round still moved a view: more rounds may help");
}

}  // namespace geond::calib
