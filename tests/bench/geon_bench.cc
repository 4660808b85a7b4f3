// SPDX-License-Identifier: Apache-2.0
// Processor time of the objective, of its derivatives and of whole fits, and the thesis' annealing on the same data.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <vector>

#include "core/geon/fit.h"
#include "core/geon/misfit.h"

namespace {

using namespace geond;

double ProcessorSeconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

// Least processor seconds of one call over some rounds.
template <typename Body>
double Least(int rounds, int calls, const Body& body) {
  double least = 1e300;
  for (int r = 0; r < rounds; ++r) {
    const double begin = ProcessorSeconds();
    for (int i = 0; i < calls; ++i) body();
    least = std::min(least, (ProcessorSeconds() - begin) / calls);
  }
  return least;
}

Geon Sample(GeonType type) {
  Geon geon;
  geon.type = type;
  geon.size = {0.02, 0.015, 0.03};
  if (IsTapered(type)) geon.taper = {0.3, 0.4};
  if (IsCurved(type)) geon.bend = 20.0;
  return geon;
}

}  // namespace

int main() {
  double sink = 0.0;
  std::printf("ns a point: objective, with derivatives; ms for all seven types; annealing over it: time, residual of own type\n");
  for (const GeonType type : kGeonTypes) {
    const Geon geon = Sample(type);
    const PointCloud cloud = SampleGeon(geon, 400);
    LanePoints points(400);
    for (int i = 0; i < 400; ++i) points.Set(i, cloud.points[i], cloud.normals[i]);
    GeonState state = StateOf(geon);
    state.size *= 1.03;
    MisfitDerivatives d;
    const double value = Least(10, 1000, [&] {
      state.size[0] += 1e-12;
      sink += SumMisfit(state, points).distance;
    });
    const double derivatives = Least(10, 300, [&] {
      state.size[0] += 1e-12;
      DifferentiateMisfit(state, points, 1.0, 1e-3, d);
      sink += d.hessian(0, 0);
    });
    PointCloud noisy = cloud;
    for (std::size_t i = 0; i < noisy.size(); ++i) {
      noisy.points[i] += 1e-4 * std::sin(12.9898 * static_cast<double>(i)) * cloud.normals[i];
    }
    FitOptions options;
    options.threads = 1;
    std::vector<GeonFit> fits, annealed;
    const double fit = Least(5, 1, [&] { fits = FitGeons(noisy, options); });
    options.optimizer = FitOptions::Optimizer::kVfsr;
    const double anneal = Least(1, 1, [&] { annealed = FitGeons(noisy, options); });
    const auto own = [&](const std::vector<GeonFit>& list) {
      return std::find_if(list.begin(), list.end(), [&](const GeonFit& f) { return f.geon.type == type; })->objective;
    };
    std::printf("%-17s %6.1f %6.1f   %6.1f ms   x %.2f   x %.2f\n", GeonTypeName(type).data(), value / 400 * 1e9,
                derivatives / 400 * 1e9, fit * 1e3, anneal / fit, own(annealed) / own(fits));
  }
  const PointCloud many = SampleGeon(Sample(GeonType::kCurvedCylinder), 100000);
  FitOptions options;
  options.threads = 1;
  std::printf("100,000 points: %.2f s\n", Least(1, 1, [&] { sink += FitGeons(many, options).front().objective; }));
  return sink == 0.0;
}
