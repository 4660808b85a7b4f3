// SPDX-License-Identifier: Apache-2.0
#include "core/geon/fit.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "core/base/parallel.h"
#include "core/geon/anneal_type.h"
#include "core/geon/deviation.h"
#include "core/geon/fit_data.h"
#include "core/geon/multi_start.h"
#include "core/geon/objective.h"
#include "core/geon/starts.h"

namespace geond {
namespace {

constexpr int kSearchPoints = 112;

void CheckOptions(const FitOptions& options) {
  if (options.types.empty()) throw std::invalid_argument("no geon type was asked for");
  for (const double v : {options.lambda, options.search_lambda, options.report_lambda, options.fallback_distance}) {
    if (!(v >= 0.0) || !std::isfinite(v)) throw std::invalid_argument("weights of the fit must be finite and not negative");
  }
  if (!(options.fallback_ratio >= 1.0)) throw std::invalid_argument("fallback_ratio must be at least 1");
  if (options.max_points < 12) throw std::invalid_argument("max_points must be at least 12");
}

// The state as a geon in the frame and unit of the data.
Geon InDataFrame(const GeonState& state, const FitData& data) {
  GeonState scaled = state;
  scaled.size *= data.unit;
  scaled.center *= data.unit;
  if (IsCurved(state.type)) scaled.deformation /= data.unit;
  Geon geon = GeonOf(scaled);
  geon.X_TG = data.X_TN * geon.X_TG;
  return Canonical(geon);
}

// The geon in the own frame and unit of the data.
GeonState InOwnFrame(const Geon& geon, const FitData& data) {
  Geon own = geon;
  own.X_TG = Inverse(data.X_TN) * geon.X_TG;
  GeonState state = StateOf(own);
  state.size /= data.unit;
  state.center /= data.unit;
  if (IsCurved(geon.type)) state.deformation *= data.unit;
  return state;
}

// Mean first-order orthogonal distance of the points used, in their own unit.
double MeanDistance(const GeonState& state, const FitData& data) {
  PointCloud cloud;
  for (int i = 0; i < data.all.size; ++i) {
    cloud.points.emplace_back(data.all.point[0][i], data.all.point[1][i], data.all.point[2][i]);
    cloud.normals.emplace_back(data.all.normal[0][i], data.all.normal[1][i], data.all.normal[2][i]);
  }
  return EvaluateObjective(GeonOf(state), cloud, 0.0).distance;
}

// Objectives this far below any that matters count as nothing when ratios are taken.
constexpr double kNothing = 1e-6;

// The place of the chosen fit: the least objective, or, if that is a deformed type and its base type is nearly as good, the
// base type (the deformed shapes contain the straight ones and win by a little on any data).
std::size_t Choose(const std::vector<GeonFit>& fits, const FitOptions& options, double diagonal) {
  std::size_t best = 0;
  for (std::size_t i = 1; i < fits.size(); ++i) if (fits[i].objective < fits[best].objective) best = i;
  const GeonType base = BaseType(fits[best].geon.type);
  for (std::size_t i = 0; i < fits.size(); ++i) {
    if (fits[i].geon.type == base &&
        fits[i].objective <= options.fallback_ratio * fits[best].objective + options.fallback_distance * diagonal) {
      return i;
    }
  }
  return best;
}

// The least objective of a type that is neither the chosen one nor a deformation of it, over the chosen one's.
double MarginOf(const std::vector<GeonFit>& fits, double diagonal) {
  double other = std::numeric_limits<double>::infinity();
  const GeonType chosen = fits.front().geon.type;
  for (std::size_t i = 1; i < fits.size(); ++i) {
    if (BaseType(fits[i].geon.type) != chosen) other = std::min(other, fits[i].objective);
  }
  return (other + kNothing * diagonal) / (fits.front().objective + kNothing * diagonal);
}

}  // namespace

std::vector<GeonFit> FitGeons(const PointCloud& part, const FitOptions& options, std::stop_token stop,
                              const StepObserver& on_step) {
  CheckOptions(options);
  const auto begin = std::chrono::steady_clock::now();
  const FitData data = PrepareFitData(part, options.max_points, kSearchPoints);
  const std::vector<Eigen::Matrix3d> frames = CandidateFrames(data.few);

  std::vector<GeonType> types = options.types;
  std::sort(types.begin(), types.end());
  types.erase(std::unique(types.begin(), types.end()), types.end());
  const int total = static_cast<int>(types.size());
  if (on_step) on_step("fit", 0, total);
  std::vector<GeonFit> fits(types.size());
  // The last types take longest: they begin first.
  ParallelFor(total, options.threads, 1, [&](std::ptrdiff_t i) {
    const std::size_t at = types.size() - 1 - static_cast<std::size_t>(i);
    GeonFit& fit = fits[at];
    RefineResult found, reported;
    if (options.optimizer == FitOptions::Optimizer::kVfsr) {
      const std::uint64_t seed = options.seed + 1000003 * static_cast<std::uint64_t>(types[at]);
      found = reported = AnnealType(types[at], data, options.lambda, seed, options.vfsr, stop);
      reported.evaluations = 0;
    } else {
      found = SearchType(types[at], data, frames, options.search_lambda, options.lambda, stop);
      reported = Polish(found.state, data, options.report_lambda);
    }
    fit.geon = InDataFrame(reported.state, data);
    fit.residual = MeanDistance(reported.state, data) * data.unit;
    fit.deviation = Deviations(InOwnFrame(fit.geon, data), data,
                               options.optimizer == FitOptions::Optimizer::kVfsr ? options.lambda : options.report_lambda);
    for (std::size_t k = 0; k < 12; ++k) {
      if (k < 3 || (k >= 6 && k < 9)) fit.deviation[k] *= data.unit;
      if (k == 11) fit.deviation[k] /= data.unit;
    }
    fit.t1 = found.t1 * data.unit;
    fit.t2 = found.t2;
    fit.objective = fit.t1 + options.lambda * found.state.gamma() * data.unit * fit.t2;
    fit.evaluations = found.evaluations + reported.evaluations;
    fit.summary.converged = found.converged && reported.converged;
    fit.summary.iterations = fit.evaluations;
    fit.summary.message = fit.summary.converged ? "converged" : "stopped before the last steps were small";
  });
  ThrowIfStopped(stop);

  const std::size_t chosen = Choose(fits, options, data.unit);
  std::rotate(fits.begin(), fits.begin() + static_cast<std::ptrdiff_t>(chosen),
              fits.begin() + static_cast<std::ptrdiff_t>(chosen) + 1);
  std::stable_sort(fits.begin() + 1, fits.end(),
                   [](const GeonFit& a, const GeonFit& b) { return a.objective < b.objective; });
  fits.front().margin = MarginOf(fits, data.unit);
  fits.front().confidence = 1.0 - std::exp(-2.0 * std::max(0.0, fits.front().margin - 1.0));
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  for (GeonFit& fit : fits) {
    fit.points = data.used;
    fit.points_dropped = data.dropped;
    fit.outliers = data.outliers;
    fit.summary.seconds = seconds;
  }
  if (on_step) on_step("fit", total, total);
  return fits;
}

}  // namespace geond
