// SPDX-License-Identifier: Apache-2.0
#include "core/geon/choose.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/geon/misfit.h"

namespace geond {
namespace {

constexpr int kStretch = 8;
// Objectives this far below any that matters count as nothing when ratios are taken; in diagonals of the data.
constexpr double kNothing = 1e-6;

struct Candidate {
  GeonType type;
  double objective = 0.0;
  std::vector<double> misfit;  // of each stretch, a point
};

std::vector<Candidate> CandidatesOf(const std::vector<RefineResult>& found, const FitData& data, double lambda) {
  std::vector<LanePoints> stretches;
  for (int begin = 0; begin < data.all.size; begin += kStretch) {
    stretches.push_back(data.all.Part(begin, std::min(kStretch, data.all.size - begin)));
  }
  std::vector<Candidate> candidates;
  for (const RefineResult& fit : found) {
    Candidate candidate{fit.state.type, ObjectiveOf(fit, data, lambda), {}};
    for (const LanePoints& stretch : stretches) {
      const MisfitSums sums = SumMisfit(fit.state, stretch);
      candidate.misfit.push_back((sums.distance + lambda * fit.state.gamma() * sums.normal) / sums.weight);
    }
    candidates.push_back(std::move(candidate));
  }
  return candidates;
}

// By how many standard errors `a` fits the data better than `b`.
double Advantage(const Candidate& a, const Candidate& b) {
  const double n = static_cast<double>(a.misfit.size());
  double mean = 0.0, square = 0.0;
  for (std::size_t i = 0; i < a.misfit.size(); ++i) mean += (b.misfit[i] - a.misfit[i]) / n;
  for (std::size_t i = 0; i < a.misfit.size(); ++i) {
    const double d = b.misfit[i] - a.misfit[i] - mean;
    square += d * d;
  }
  if (a.misfit.size() < 2) return 0.0;
  return mean / (std::sqrt(square / (n - 1.0) / n) + 1e-3 * kNothing);
}

double Ratio(const Candidate& other, const Candidate& chosen) {
  return (other.objective + kNothing) / (chosen.objective + kNothing);
}

std::size_t Choose(const std::vector<Candidate>& candidates, const FitOptions& options) {
  const auto best = static_cast<std::size_t>(
      std::min_element(candidates.begin(), candidates.end(),
                       [](const Candidate& a, const Candidate& b) { return a.objective < b.objective; }) -
      candidates.begin());
  const Candidate& least = candidates[best];
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const Candidate& base = candidates[i];
    if (i == best || base.type != BaseType(least.type)) continue;
    const bool by_ratio = base.objective <= options.fallback_ratio * least.objective + options.fallback_distance;
    const bool by_scatter = base.objective <= options.fallback_scatter_ratio * least.objective &&
                            Advantage(least, base) < options.fallback_errors;
    if (by_ratio || by_scatter) return i;
  }
  return best;
}

// The least logarithm of another type's objective over the chosen one's, deformations of the chosen one aside: those
// are below it by choice.
double LeastLogRatio(const std::vector<Candidate>& candidates, std::size_t chosen) {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    if (i == chosen || BaseType(candidates[i].type) == candidates[chosen].type) continue;
    least = std::min(least, std::log(Ratio(candidates[i], candidates[chosen])));
  }
  return least;
}

// Logistic regression of right and wrong on 1,478 simulated scans of random geons (1, 2 and 4 views, 100 and 400
// points, noise 0.5 to 3 %, with and without outliers), 33 of them wrong; fit_confidence_validation checks it on
// others.
double ConfidenceOf(double log_ratio, bool one_view) {
  const double log_odds = 2.0 + 5.5 * std::clamp(log_ratio, -0.2, 2.0) - (one_view ? 1.5 : 0.0);
  return 1.0 / (1.0 + std::exp(-log_odds));
}

}  // namespace

Choice ChooseType(const std::vector<RefineResult>& found, const FitData& data, const FitOptions& options) {
  const std::vector<Candidate> candidates = CandidatesOf(found, data, options.lambda);
  Choice choice;
  choice.chosen = Choose(candidates, options);
  if (candidates.size() == 1) return choice;  // nothing to compare with
  const double log_ratio = LeastLogRatio(candidates, choice.chosen);
  choice.margin = std::exp(log_ratio);
  choice.confidence = ConfidenceOf(log_ratio, !data.view.isZero());
  return choice;
}

}  // namespace geond
