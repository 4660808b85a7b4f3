// SPDX-License-Identifier: Apache-2.0
// How often the type is right when the confidence says so, on simulated scans of random geons, good and bad:
// fit_confidence_validation [geons a type and condition] [seed]. Then the logistic line of right and wrong against the
// stated log-odds: slope 1 and offset 0 if they are what they say.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "core/geon/fit.h"
#include "tests/validation/geon_views.h"

namespace geond {
namespace {

struct Outcome {
  double confidence = 0.0;
  bool right = false;
};

// Maximum likelihood of p = 1 / (1 + exp(-(offset + slope log-odds))), by Newton.
void PrintLine(const std::vector<Outcome>& outcomes) {
  Eigen::Vector2d line(0.0, 1.0);
  for (int step = 0; step < 30; ++step) {
    Eigen::Vector2d gradient = Eigen::Vector2d::Zero();
    Eigen::Matrix2d curvature = 1e-9 * Eigen::Matrix2d::Identity();
    for (const Outcome& o : outcomes) {
      const double c = std::clamp(o.confidence, 1e-6, 1.0 - 1e-6);
      const Eigen::Vector2d x(1.0, std::log(c / (1.0 - c)));
      const double p = 1.0 / (1.0 + std::exp(-line.dot(x)));
      gradient += (o.right - p) * x;
      curvature += p * (1.0 - p) * x * x.transpose();
    }
    line += curvature.ldlt().solve(gradient);
  }
  std::printf("log-odds of being right: %.2f + %.2f of those stated\n", line[0], line[1]);
}

int Run(int argc, char** argv) {
  const int count = argc > 1 ? std::atoi(argv[1]) : 10;
  const std::uint64_t seed = argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 1;
  const ViewOptions conditions[] = {{4, 400, 0.01, 40}, {1, 400, 0.005, 24},          {1, 400, 0.01, 40},
                                    {1, 400, 0.02, 80}, {1, 100, 0.01, 40},           {4, 100, 0.03, 80},
                                    {2, 100, 0.02, 80}, {1, 400, 0.01, 40, 2500, 0.1}};
  std::vector<Outcome> outcomes;
  for (const ViewOptions& views : conditions) {
    for (const GeonType type : kGeonTypes) {
      Draw draw(seed * 1000 + static_cast<std::uint64_t>(type));
      for (int i = 0; i < count; ++i) {
        const Geon truth = Canonical(RandomGeon(type, draw));
        const auto fits = FitGeons(ViewsOfGeon(truth, views, draw));
        outcomes.push_back({fits.front().confidence, fits.front().geon.type == type});
      }
    }
  }
  const double edges[] = {0.0, 0.5, 0.7, 0.8, 0.9, 0.95, 0.98, 1.0};
  std::printf("%-12s %6s %9s %9s\n", "confidence", "cases", "stated", "right");
  for (std::size_t b = 0; b + 1 < std::size(edges); ++b) {
    double stated = 0.0;
    int n = 0, right = 0;
    for (const Outcome& o : outcomes) {
      if (o.confidence < edges[b] || (o.confidence >= edges[b + 1] && b + 2 < std::size(edges))) continue;
      stated += o.confidence;
      right += o.right;
      ++n;
    }
    if (n > 0)
      std::printf("%.2f - %.2f  %6d %9.3f %9.3f\n", edges[b], edges[b + 1], n, stated / n,
                  static_cast<double>(right) / n);
  }
  PrintLine(outcomes);
  return 0;
}

}  // namespace
}  // namespace geond

int main(int argc, char** argv) { return geond::Run(argc, argv); }
