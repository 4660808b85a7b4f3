// SPDX-License-Identifier: Apache-2.0
#include "core/geon/vfsr.h"

#include <cmath>
#include <numbers>
#include <stdexcept>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/geon/fit.h"
#include "core/geon/objective.h"
#include "tests/core/geon/random_geon.h"

namespace geond {
namespace {

// Rastrigin's function: a bowl with a local minimum at every integer, least (1) at 0.3 in every parameter.
double Rastrigin(std::span<const double> p) {
  double sum = 1.0;
  for (const double x : p) sum += (x - 0.3) * (x - 0.3) + 2.0 * (1.0 - std::cos(2.0 * std::numbers::pi * (x - 0.3)));
  return sum;
}

VfsrOptions Patient() {
  VfsrOptions options;
  options.relative_difference = 0.0;
  options.most_repeats = 1000000;
  options.least_temperature = 1e-100;
  return options;
}

TEST(Anneal, FindsTheDeepestOfManyMinima) {
  const std::vector<VfsrRange> ranges(4, {-5.0, 5.0});
  int deepest = 0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) deepest += Anneal(Rastrigin, ranges, seed, Patient()).value < 1.5;
  EXPECT_GE(deepest, 9);
}

TEST(Anneal, IsTheSameForTheSameSeedAndStaysInItsBounds) {
  const std::vector<VfsrRange> ranges = {{-5.0, 5.0}, {0.5, 5.0}, {-1.0, 1.0, true}};
  const auto inside = [&](std::span<const double> p) {
    for (std::size_t i = 0; i < ranges.size(); ++i) {
      EXPECT_GE(p[i], ranges[i].low);
      EXPECT_LE(p[i], ranges[i].high);
    }
    return Rastrigin(p);
  };
  const VfsrResult a = Anneal(inside, ranges, 7), b = Anneal(inside, ranges, 7), c = Anneal(inside, ranges, 8);
  EXPECT_EQ(a.parameters, b.parameters);
  EXPECT_NE(a.parameters, c.parameters);
}

TEST(Anneal, EndsForEachOfTheSixReasons) {
  const std::vector<VfsrRange> ranges(2, {-5.0, 5.0});
  const auto stop = [&](const VfsrOptions& options, auto&& f) { return Anneal(f, ranges, 3, options).stop; };
  VfsrOptions o = Patient();
  o.most_evaluations = 500;
  EXPECT_EQ(stop(o, Rastrigin), VfsrStop::kEvaluations);
  o = Patient();
  o.least_value = 20.0;
  EXPECT_EQ(stop(o, Rastrigin), VfsrStop::kValue);
  o = Patient();
  o.least_temperature = 1e-3;
  EXPECT_EQ(stop(o, Rastrigin), VfsrStop::kTemperature);
  o = Patient();
  o.most_acceptances = 20;
  EXPECT_EQ(stop(o, Rastrigin), VfsrStop::kAcceptances);
  o = Patient();
  o.most_repeats = 50;
  EXPECT_EQ(stop(o, [](std::span<const double>) { return 2.0; }), VfsrStop::kRepeats);
  o = Patient();
  o.relative_difference = 0.5;
  EXPECT_EQ(stop(o, Rastrigin), VfsrStop::kDifference);
}

TEST(Anneal, RefusesEmptyRangesAndStopsWhenAsked) {
  EXPECT_THROW(Anneal(Rastrigin, {}, 1), std::invalid_argument);
  EXPECT_THROW(Anneal(Rastrigin, std::vector<VfsrRange>{{1.0, 1.0}}, 1), std::invalid_argument);
  std::stop_source source;
  source.request_stop();
  EXPECT_THROW(Anneal(Rastrigin, std::vector<VfsrRange>{{0.0, 1.0}}, 1, Patient(), source.get_token()), Cancelled);
}

TEST(FitGeons, AnnealsAnEllipsoidAndReportsItsObjective) {
  Draw draw(200);
  const Geon truth = RandomGeon(GeonType::kEllipsoid, draw);
  const PointCloud part = SampleGeon(truth, 200);
  FitOptions options;
  options.optimizer = FitOptions::Optimizer::kVfsr;
  options.types = {GeonType::kEllipsoid};
  options.vfsr = Patient();
  const std::vector<GeonFit> fits = FitGeons(part, options);
  EXPECT_LE(fits[0].evaluations, 10000);
  EXPECT_LT(fits[0].objective, 0.2 * truth.size.norm());
  EXPECT_NEAR(EvaluateObjective(fits[0].geon, part, options.lambda).value, fits[0].objective, 1e-6 * fits[0].objective);
}

}  // namespace
}  // namespace geond
