// SPDX-License-Identifier: Apache-2.0
#include "core/geon/fit.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "core/base/parallel.h"
#include "core/geon/anneal_type.h"
#include "core/geon/choose.h"
#include "core/geon/deviation.h"
#include "core/geon/ends.h"
#include "core/geon/fit_data.h"
#include "core/geon/multi_start.h"
#include "core/geon/objective.h"
#include "core/geon/starts.h"

namespace geond {
namespace {

constexpr int kSearchPoints = 112;

void CheckOptions(const FitOptions& options) {
  if (options.types.empty()) throw std::invalid_argument("no geon type was asked for");
  for (const double v : {options.lambda, options.search_lambda, options.report_lambda, options.fallback_distance,
                         options.fallback_errors, options.fallback_scatter_ratio, options.least_gamma}) {
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

// The least objective of one type.
RefineResult FindType(GeonType type, const FitData& data, const std::vector<Eigen::Matrix3d>& frames, const GeonState* base,
                      const FitOptions& options, std::stop_token stop) {
  if (options.optimizer == FitOptions::Optimizer::kVfsr) {
    return AnnealType(type, data, options.lambda, options.seed + 1000003 * static_cast<std::uint64_t>(type), options.vfsr, stop);
  }
  return SearchType(type, data, frames, options, base, stop);
}

// What is reported of it: if it is the chosen one, parameters refined at report_lambda, without the length that nobody saw;
// annealed ones as they are.
GeonFit Report(const RefineResult& found, const FitData& data, const FitOptions& options, bool chosen) {
  RefineResult reported = found;
  double lambda = options.lambda;
  int evaluations = found.evaluations;
  if (chosen && options.optimizer == FitOptions::Optimizer::kMultiStart) {
    lambda = options.report_lambda;
    reported = Polish(found.state, data, lambda, options.least_gamma, 1e-9);
    evaluations += reported.evaluations;
    reported.state = WithoutHiddenLength(reported.state, data);
  }
  GeonFit fit;
  fit.geon = InDataFrame(reported.state, data);
  fit.residual = MeanDistance(reported.state, data) * data.unit;
  const GeonState canonical = InOwnFrame(fit.geon, data);
  const Ends ends = JudgeEnds(canonical, data);
  fit.ends = ends.state;
  fit.deviation = Deviations(canonical, data, lambda, ends);
  for (std::size_t k = 0; k < 12; ++k) {
    if (k < 3 || (k >= 6 && k < 9)) fit.deviation[k] *= data.unit;
    if (k == 11) fit.deviation[k] /= data.unit;
  }
  fit.t1 = found.t1 * data.unit;
  fit.t2 = found.t2;
  fit.objective = ObjectiveOf(found, data, options.lambda) * data.unit;
  fit.evaluations = evaluations;
  fit.summary.converged = found.converged && reported.converged;
  fit.summary.iterations = evaluations;
  fit.summary.message = fit.summary.converged ? "converged" : "stopped before the last steps were small";
  return fit;
}

}  // namespace

std::vector<GeonFit> FitGeons(const PointCloud& part, const FitOptions& options, std::stop_token stop,
                              const StepObserver& on_step, const Surroundings& around) {
  CheckOptions(options);
  const auto begin = std::chrono::steady_clock::now();
  const FitData data = PrepareFitData(part, around, options.outline_of_one_view, options.max_points, kSearchPoints);
  std::vector<Eigen::Matrix3d> frames = CandidateFrames(data.few);

  std::vector<GeonType> types = options.types;
  std::sort(types.begin(), types.end());
  types.erase(std::unique(types.begin(), types.end()), types.end());
  const int total = static_cast<int>(types.size());
  if (on_step) on_step("fit", 0, total);
  std::vector<GeonFit> fits(types.size());
  std::vector<RefineResult> found(types.size());
  // The base types first, from which the deformed ones begin as well. The last types take longest: they begin first.
  for (const bool deformed : {false, true}) {
    ParallelFor(total, options.threads, 1, [&](std::ptrdiff_t i) {
      const std::size_t at = types.size() - 1 - static_cast<std::size_t>(i);
      if ((BaseType(types[at]) != types[at]) != deformed) return;
      const auto base = std::find(types.begin(), types.end(), BaseType(types[at]));
      const GeonState* base_state = base != types.end() ? &found[static_cast<std::size_t>(base - types.begin())].state : nullptr;
      found[at] = FindType(types[at], data, frames, base_state, options, stop);
    });
    ThrowIfStopped(stop);
    if (deformed || !options.thorough) continue;
    for (std::size_t at = 0; at < types.size(); ++at) {
      if (BaseType(types[at]) == types[at]) AddFrame(found[at].state.rotation, frames);
    }
  }

  const Choice choice = ChooseType(found, data, options);
  for (std::size_t at = 0; at < types.size(); ++at) fits[at] = Report(found[at], data, options, at == choice.chosen);
  const auto chosen = fits.begin() + static_cast<std::ptrdiff_t>(choice.chosen);
  std::rotate(fits.begin(), chosen, chosen + 1);
  std::stable_sort(fits.begin() + 1, fits.end(),
                   [](const GeonFit& a, const GeonFit& b) { return a.objective < b.objective; });
  fits.front().margin = choice.margin;
  fits.front().confidence = choice.confidence;
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
