// SPDX-License-Identifier: Apache-2.0
// Time of the segmentation alone, the charge being given, on a string of four beads: seconds a million triangles should
// hardly grow with the number of triangles.
#include <benchmark/benchmark.h>

#include <cmath>
#include <numbers>

#include "core/parts/segment.h"

namespace geond {
namespace {

// A solid of revolution with `rings` rings and necks between four beads; the charge taken as that of its thickness.
void MakeBeads(int rings, TriangleMesh& mesh, ChargeDensity& charge) {
  const int around = rings / 4;
  const auto radius = [](double u) { return 0.02 + std::abs(std::sin(4.0 * std::numbers::pi * u)); };
  for (int i = 0; i <= rings; ++i) {
    const double u = static_cast<double>(i) / rings;
    for (int k = 0; k < around; ++k) {
      const double a = 2.0 * std::numbers::pi * k / around;
      mesh.vertices.emplace_back(radius(u) * std::cos(a), radius(u) * std::sin(a), 7.0 * u);
    }
  }
  for (int i = 0; i < rings; ++i) {
    for (int k = 0; k < around; ++k) {
      const int a = i * around + k, b = i * around + (k + 1) % around;
      mesh.triangles.push_back({a, b, a + around});
      mesh.triangles.push_back({b, b + around, a + around});
    }
  }
  for (int t = 0; t < static_cast<int>(mesh.triangles.size()); ++t) {
    charge.density.push_back(0.1 + radius(TriangleCentroid(mesh, t).z() / 7.0));
  }
}

void BM_SegmentParts(benchmark::State& state) {
  TriangleMesh mesh;
  ChargeDensity charge;
  MakeBeads(static_cast<int>(state.range(0)), mesh, charge);
  int n_parts = 0;
  for (auto _ : state) n_parts = SegmentParts(mesh, charge).n_parts;
  state.counters["triangles"] = static_cast<double>(mesh.triangles.size());
  state.counters["parts"] = n_parts;
  state.counters["triangles_per_second"] =
      benchmark::Counter(static_cast<double>(mesh.triangles.size()), benchmark::Counter::kIsIterationInvariantRate);
}
BENCHMARK(BM_SegmentParts)->Arg(140)->Arg(450)->Unit(benchmark::kMillisecond)->Iterations(1);

}  // namespace
}  // namespace geond

BENCHMARK_MAIN();
