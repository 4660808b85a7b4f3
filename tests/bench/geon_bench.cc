// SPDX-License-Identifier: Apache-2.0
// Processor time of the objective, of its derivatives and of whole fits; the first two beside what the processor could do,
// the last beside the thesis' annealing with 10,000 evaluations a type on the same data.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <vector>

#if defined(__x86_64__)
#include <immintrin.h>
#endif

#include "core/geon/fit.h"
#include "core/geon/misfit.h"
#include "core/geon/objective.h"

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

// Arithmetic operations a point of the objective and with derivatives (fused multiplications and additions are two),
// counted in the machine code for AVX-512.
constexpr int kOperations[7][2] = {{141, 635},  {196, 719},  {205, 710}, {221, 1070},
                                   {230, 1061}, {318, 1051}, {327, 1042}};

#if defined(__x86_64__)
// Twelve chains of fused multiplications and additions, so that none waits for another.
__attribute__((target("avx512f"))) double FuseWide(int steps) {
  __m512d sum[12];
  for (__m512d& s : sum) s = _mm512_set1_pd(1.0);
  const __m512d a = _mm512_set1_pd(0.999999), b = _mm512_set1_pd(1e-7);
  for (int i = 0; i < steps; ++i) {
#pragma GCC unroll 12
    for (__m512d& s : sum) s = _mm512_fmadd_pd(s, a, b);
  }
  double total = 0.0;
  for (const __m512d& s : sum) {
    for (int k = 0; k < 8; ++k) total += s[k];
  }
  return total;
}
__attribute__((target("avx2,fma"))) double FuseNarrow(int steps) {
  __m256d sum[12];
  for (__m256d& s : sum) s = _mm256_set1_pd(1.0);
  const __m256d a = _mm256_set1_pd(0.999999), b = _mm256_set1_pd(1e-7);
  for (int i = 0; i < steps; ++i) {
#pragma GCC unroll 12
    for (__m256d& s : sum) s = _mm256_fmadd_pd(s, a, b);
  }
  double total = 0.0;
  for (const __m256d& s : sum) total += s[0] + s[1] + s[2] + s[3];
  return total;
}
#endif

// Operations a nanosecond that one core does at most, as measured; 0 where we do not know how to ask.
double PeakOperations(double& sink) {
#if defined(__x86_64__)
  constexpr int kSteps = 20000;
  if (__builtin_cpu_supports("avx512f")) return 12 * 16 * kSteps / (1e9 * Least(30, 1, [&] { sink += FuseWide(kSteps); }));
  if (__builtin_cpu_supports("avx2")) return 12 * 8 * kSteps / (1e9 * Least(30, 1, [&] { sink += FuseNarrow(kSteps); }));
#endif
  return 0.0;
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
  const double peak = PeakOperations(sink);
  std::printf("the processor: at most %.1f operations a ns\n"
              "ns a point: objective (share of that), with derivatives (share); ms and evaluations for all seven types at 400 "
              "points; annealing over it: time, residual of own type\n", peak);
  double log_time = 0.0, log_plain = 0.0, log_residual = 0.0, milliseconds = 0.0;
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
    int of_annealing = 0;
    for (const GeonFit& f : annealed) of_annealing += f.evaluations;
    // What so many evaluations take if each point is taken by itself, as it was done in 1996.
    const double plain = of_annealing * Least(3, 5, [&] { sink += EvaluateObjective(geon, noisy, 5.0).value; });
    const auto own = [&](const std::vector<GeonFit>& list) {
      return std::find_if(list.begin(), list.end(), [&](const GeonFit& f) { return f.geon.type == type; })->objective;
    };
    const int* const operations = kOperations[static_cast<int>(type) - 1];
    const auto share = [&](int count, double seconds) { return peak > 0.0 ? 100.0 * count / (seconds / 400 * 1e9) / peak : 0.0; };
    int evaluations = 0;
    for (const GeonFit& f : fits) evaluations += f.evaluations;
    std::printf("%-17s %5.1f (%2.0f %%) %5.1f (%2.0f %%)   %5.1f ms %6d   x %.1f, point by point x %.0f   x %.2f\n", GeonTypeName(type).data(),
                value / 400 * 1e9, share(operations[0], value), derivatives / 400 * 1e9, share(operations[1], derivatives),
                fit * 1e3, evaluations, anneal / fit, plain / fit, own(annealed) / own(fits));
    log_time += std::log(anneal / fit) / 7.0;
    log_plain += std::log(plain / fit) / 7.0;
    log_residual += std::log(own(annealed) / own(fits)) / 7.0;
    milliseconds += 1e3 * fit / 7.0;
  }
  std::printf("mean %.1f ms; annealing on the mean x %.1f the time (point by point x %.0f) for x %.2f the residual\n", milliseconds,
              std::exp(log_time), std::exp(log_plain), std::exp(log_residual));
  const PointCloud many = SampleGeon(Sample(GeonType::kCurvedCylinder), 100000);
  FitOptions options;
  options.threads = 1;
  std::printf("100,000 points: %.2f s\n", Least(3, 1, [&] { sink += FitGeons(many, options).front().objective; }));
  return sink == 0.0;
}
