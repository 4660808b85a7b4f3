// SPDX-License-Identifier: Apache-2.0
#include "core/geon/multi_start.h"

#include <algorithm>

#include "core/base/progress.h"
#include "core/geon/starts.h"

namespace geond {
namespace {

// Rounds of the search on few points: how many candidates stay, how many steps each gets, and whether at the lambda of the
// search or of the choice.
struct Round {
  int keep, steps;
  bool at_search_lambda;
  double floor;
};
constexpr Round kRounds[] = {{40, 4, true, 1e-2}, {16, 6, true, 3e-3}, {12, 8, false, 3e-3}, {6, 8, false, 1e-3}};
constexpr int kFinalists = 6;

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

}  // namespace

ParameterBounds BoundsOf(const FitData& data) {
  ParameterBounds bounds;
  bounds.center = data.box.center();
  return bounds;
}

double ObjectiveOf(const RefineResult& fit, const FitData& data, double lambda) {
  const MisfitSums sums = SumMisfit(fit.state, data.all);
  return (sums.distance + lambda * fit.state.gamma() * sums.normal + sums.covered) / sums.weight;
}

RefineResult Polish(const GeonState& start, const FitData& data, double lambda) {
  const ParameterBounds bounds = BoundsOf(data);
  RefineResult result;
  result.state = start;
  int evaluations = 0;
  double t1 = SumMisfit(start, data.all).distance / data.all.size;
  for (int pass = 0; pass < 3; ++pass) {
    RefineOptions options;
    options.lambda = lambda;
    options.floor = std::max(0.1 * t1, 1e-9);
    options.iterations = pass == 0 ? 30 : 40;
    options.tolerance = pass == 0 ? 1e-4 : 1e-9;
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
                        double search_lambda, double lambda, const GeonState* base, std::stop_token stop) {
  const ParameterBounds bounds = BoundsOf(data);
  RefineOptions options;
  options.lambda = search_lambda;
  options.floor = 1e-2;
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
  bool base_to_come = base != nullptr && BaseType(type) != type;
  for (const Round& round : kRounds) {
    ThrowIfStopped(stop);
    KeepBest(candidates, round.keep);
    options.iterations = round.steps;
    options.lambda = round.at_search_lambda ? search_lambda : lambda;
    options.floor = round.floor;
    if (base_to_come && !round.at_search_lambda) {
      begin_at(StartsFromBase(type, *base));
      base_to_come = false;
    }
    for (RefineResult& candidate : candidates) {
      candidate = Refine(candidate.state, data.few, bounds, options);
      evaluations += candidate.evaluations;
    }
    KeepBest(candidates, round.keep);
    DropTwins(candidates);
  }
  KeepBest(candidates, kFinalists);
  for (RefineResult& candidate : candidates) {
    ThrowIfStopped(stop);
    options.iterations = 12;
    options.lambda = lambda;
    candidate = Refine(candidate.state, data.all, bounds, options);
    evaluations += candidate.evaluations;
  }
  KeepBest(candidates, 1);
  RefineResult best = Polish(candidates.front().state, data, lambda);
  best.evaluations += evaluations;
  return best;
}

}  // namespace geond
