// SPDX-License-Identifier: Apache-2.0
#include "core/geon/multi_start.h"

#include <algorithm>

#include "core/base/progress.h"
#include "core/geon/starts.h"

namespace geond {
namespace {

// Rounds of the search: how many candidates begin it, how many steps each gets, at the lambda of the search or of the
// choice, with which floor, on few points or on all.
struct Round {
  int keep, steps;
  bool at_search_lambda;
  double floor;
  bool on_all;
};
constexpr Round kRounds[] = {{40, 4, true, 1e-2, false}, {16, 6, true, 3e-3, false}, {12, 8, false, 3e-3, false},
                             {6, 8, false, 1e-3, false}, {6, 4, false, 1e-3, true},  {3, 8, false, 1e-3, true}};
constexpr int kThorough = 200;   // candidates kept by a thorough search

void KeepBest(std::vector<RefineResult>& candidates, std::size_t count) {
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const RefineResult& a, const RefineResult& b) { return a.objective < b.objective; });
  if (candidates.size() > count) candidates.resize(count);
}

// Drops candidates that came to the same minimum as a better one.
void DropTwins(std::vector<RefineResult>& candidates) {
  std::vector<RefineResult> distinct;
  for (const RefineResult& c : candidates) {
    const bool twin = std::any_of(distinct.begin(), distinct.end(), [&](const RefineResult& d) {
      return std::abs(c.objective - d.objective) < 1e-4 * d.objective && (c.state.center - d.state.center).norm() < 1e-3 &&
             std::abs(c.state.size.prod() - d.state.size.prod()) < 0.01 * d.state.size.prod();
    });
    if (!twin) distinct.push_back(c);
  }
  candidates = std::move(distinct);
}

ParameterBounds BoundsOf(const FitData& data, double least_gamma) {
  ParameterBounds bounds;
  bounds.center = data.box.center();
  bounds.least_gamma = least_gamma;
  return bounds;
}

// The search with its first rounds at `search_lambda`.
RefineResult SearchAt(double search_lambda, GeonType type, const FitData& data, const std::vector<Eigen::Matrix3d>& frames,
                      const FitOptions& fit, const GeonState* base, std::stop_token stop) {
  const ParameterBounds bounds = BoundsOf(data, fit.least_gamma);
  RefineOptions options;
  options.lambda = search_lambda;
  options.floor = kRounds[0].floor;
  options.tolerance = 1e-4;
  int evaluations = 0;
  std::vector<RefineResult> candidates;
  const auto begin_at = [&](const std::vector<GeonState>& starts) {
    for (const GeonState& start : starts) {
      RefineResult candidate;
      candidate.state = Bounded(start, bounds);
      const MisfitSums sums = SumMisfit(candidate.state, data.few, options.floor);
      candidate.objective = (sums.smooth + options.lambda * candidate.state.gamma() * sums.normal) / sums.weight;
      candidates.push_back(candidate);
      ++evaluations;
    }
  };
  begin_at(StartStates(type, frames, data.few, data.view));
  bool base_to_come = base != nullptr;
  for (const Round& round : kRounds) {
    ThrowIfStopped(stop);
    KeepBest(candidates, fit.thorough ? kThorough : round.keep);
    options.iterations = round.steps;
    options.lambda = round.at_search_lambda ? search_lambda : fit.lambda;
    options.floor = round.floor;
    if (base_to_come && !round.at_search_lambda) {
      begin_at(StartsFromBase(type, *base));
      base_to_come = false;
    }
    for (RefineResult& candidate : candidates) {
      candidate = Refine(candidate.state, round.on_all ? data.all : data.few, bounds, options);
      evaluations += candidate.evaluations;
    }
    KeepBest(candidates, candidates.size());
    DropTwins(candidates);
  }
  RefineResult best = Polish(candidates.front().state, data, fit.lambda, fit.least_gamma, 1e-7);
  best.evaluations += evaluations;
  return best;
}

}  // namespace

double ObjectiveOf(const RefineResult& fit, const FitData& data, double lambda) {
  const MisfitSums sums = SumMisfit(fit.state, data.all);
  return (sums.distance + lambda * fit.state.gamma() * sums.normal + sums.covered) / sums.weight;
}

RefineResult Polish(const GeonState& start, const FitData& data, double lambda, double least_gamma, double tolerance) {
  const ParameterBounds bounds = BoundsOf(data, least_gamma);
  RefineResult result;
  result.state = start;
  int evaluations = 0;
  double t1 = SumMisfit(start, data.all).distance / data.all.size;
  for (int pass = 0; pass < 3; ++pass) {
    RefineOptions options;
    options.lambda = lambda;
    options.floor = std::max(0.1 * t1, 1e-9);
    options.iterations = pass == 0 ? 30 : 40;
    options.tolerance = pass == 0 ? 1e-4 : tolerance;
    options.damping = 1e-4;
    result = Refine(result.state, data.all, bounds, options);
    evaluations += result.evaluations;
    if (pass > 0 && result.t1 > 0.7 * t1) break;
    t1 = result.t1;
  }
  result.evaluations = evaluations;
  return result;
}

RefineResult SearchType(GeonType type, const FitData& data, const std::vector<Eigen::Matrix3d>& frames,
                        const FitOptions& options, const GeonState* base, std::stop_token stop) {
  if (BaseType(type) == type) base = nullptr;
  RefineResult best = SearchAt(options.search_lambda, type, data, frames, options, base, stop);
  if (options.thorough) {
    const RefineResult other = SearchAt(10.0 * options.search_lambda, type, data, frames, options, base, stop);
    const int evaluations = best.evaluations + other.evaluations;
    if (other.objective < best.objective) best = other;
    best.evaluations = evaluations;
  }
  return best;
}

}  // namespace geond
