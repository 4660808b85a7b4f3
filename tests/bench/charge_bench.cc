// SPDX-License-Identifier: Apache-2.0
// The charge solve against time: the fast solver against the exact matrix where that fits, then alone on growing
// spheres and cubes, each with its roofline. CPU seconds over all threads, and the wall's. Usage: charge_bench [largest
// number of triangles, 100000].
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>

#include "core/charge/charge_density.h"
#include "core/charge/fast.h"
#include "core/charge/kernels.h"
#include "core/charge/panels.h"
#include "tests/core/charge/shapes.h"

namespace {

using namespace geond;

double CpuSeconds() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

struct Timed {
  ChargeDensity charge;
  double cpu, wall;
};

Timed Solve(const TriangleMesh& mesh, ChargeOptions::Solver solver) {
  ChargeOptions options;
  options.solver = solver;
  const double cpu = CpuSeconds();
  const auto start = std::chrono::steady_clock::now();
  Timed timed{SolveChargeDensity(mesh, options), 0.0, 0.0};
  timed.cpu = CpuSeconds() - cpu;
  timed.wall = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return timed;
}

void Compare(const char* name, const TriangleMesh& mesh) {
  const Timed fast = Solve(mesh, ChargeOptions::Solver::kFast), exact = Solve(mesh, ChargeOptions::Solver::kDense);
  const double rms = shapes::RelativeRms(mesh, fast.charge.density, exact.charge.density);
  std::printf("%-8s %8zu  fast %8.4f CPU s, exact %8.4f, ratio %7.1f  difference %.1e rms\n", name,
              mesh.triangles.size(), fast.cpu, exact.cpu, exact.cpu / fast.cpu, rms);
}

// What two cores of 2.5 GHz with AVX-512 were measured to give together: the bounds that follow are theirs.
constexpr double kBytesASecond = 27e9, kFloatsASecond = 2 * 217e9, kInversesASecond = 2 * 6.1e9,
                 kExactSeconds = 3.2e-9 / 2;

// For each phase what it must read and write and compute, and the least wall seconds that this takes at the machine's
// peaks beside those that it took.
void Roofline(const TriangleMesh& mesh) {
  const charge::Panels panels = charge::MakePanels(mesh);
  const charge::FastSettings settings = charge::FastSettingsFor(5e-4, panels.size());
  charge::FastReport report;
  const charge::UnitPotentialSolution solution = charge::SolveFast(mesh, panels, settings, 0, {}, {}, &report);
  const double passes = solution.summary.iterations;
  const auto near = static_cast<double>(report.near_pairs), exact = static_cast<double>(report.exact_pairs);
  const auto inverses = static_cast<double>(report.preconditioner_bytes) / sizeof(float);
  const auto row = [](const char* phase, double seconds, double bytes, double flops, double other) {
    const double memory = bytes / kBytesASecond, compute = flops / kFloatsASecond + other;
    std::printf("         %-22s ", phase);
    if (seconds > 0.0) std::printf("%8.4f s", seconds);
    std::printf("%s %8.3f GB %9.3f Gflop  at least %.4f s, held by %s\n", seconds > 0.0 ? " " : "           ",
                bytes / 1e9, flops / 1e9, std::max(memory, compute), memory > compute ? "memory" : "arithmetic");
  };
  // Three points stand for a triangle that is not near enough for the exact integral.
  row("near integrals", report.near_seconds, static_cast<double>(report.near_bytes), 0.0,
      exact * kExactSeconds + 3.0 * near / kInversesASecond);
  // A local inverse of m members of which o are its own takes 2/3 m^3 + 2 m^2 o: some 3 m^2 for each of m o entries.
  const double members = settings.halo + static_cast<double>(panels.size()) / static_cast<double>(report.leaves);
  row("preconditioner", report.preconditioner_seconds, static_cast<double>(report.preconditioner_bytes),
      3.0 * members * inverses, 0.0);
  row("products: near", 0.0, passes * static_cast<double>(report.near_bytes), passes * 2.0 * near, 0.0);
  row("products: far", 0.0, passes * static_cast<double>(report.far_bytes),
      passes * 2.0 * static_cast<double>(report.far_multiplications), 0.0);
  row("products: inverses", 0.0, passes * static_cast<double>(report.preconditioner_bytes), passes * 2.0 * inverses,
      0.0);
  std::printf(
      "         all products took %.4f s; tree %.4f, far matrices %.4f; the exact integral of %.0f of %.0f pairs a "
      "triangle\n",
      report.product_seconds, report.tree_seconds, report.far_seconds, exact / static_cast<double>(panels.size()),
      near / static_cast<double>(panels.size()));
}

void Grow(const char* name, const TriangleMesh& mesh) {
  static double last_cpu = 0.0, last_n = 0.0;
  const Timed fast = Solve(mesh, ChargeOptions::Solver::kFast);
  const auto n = static_cast<double>(mesh.triangles.size());
  const double exponent = last_n > 0.0 && last_n < n ? std::log(fast.cpu / last_cpu) / std::log(n / last_n) : 0.0;
  std::printf("%-8s %8.0f  %8.4f CPU s  %8.4f s (setup %.4f)  %3d iterations  %7.1f MB  grows as N^%.2f  C %.6f\n",
              name, n, fast.cpu, fast.wall, fast.charge.setup_seconds, fast.charge.summary.iterations,
              static_cast<double>(fast.charge.peak_bytes) / 1e6, exponent, fast.charge.capacitance);
  const ChargePhases& t = fast.charge.seconds;
  std::printf(
      "         tree %.4f near %.4f far %.4f preconditioner %.4f products %.4f s, %.0f near pairs a triangle, error <= "
      "%.1e\n",
      t.tree, t.near, t.far, t.preconditioner, t.products, static_cast<double>(fast.charge.near_pairs) / n,
      fast.charge.error_estimate);
  Roofline(mesh);
  last_cpu = fast.cpu, last_n = n;
}

// CPU nanoseconds of one exact integral in a run of many: what the machine is worth while this program runs (9.3 on a
// quiet core of 2.5 GHz with a vendor's logarithm).
void MachineNow() {
  std::vector<double> x(4096), y(4096, 0.3), z(4096, 0.1), integral(4096);
  for (std::size_t i = 0; i < x.size(); ++i) x[i] = 1e-3 * static_cast<double>(i);
  const charge::TriangleFrame frame = charge::MakeTriangleFrame({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  const double cpu = CpuSeconds();
  for (int i = 0; i < 50; ++i) {
    charge::BestKernels().double_precision.triangle_potential(frame, x.data(), y.data(), z.data(), 4096,
                                                              integral.data());
  }
  std::printf("exact integral: %.1f ns (%s)\n", (CpuSeconds() - cpu) / (50 * 4096) * 1e9, charge::BestKernels().name);
}

}  // namespace

int main(int argc, char** argv) {
  const long largest = argc > 1 ? std::atol(argv[1]) : 100000;
  MachineNow();
  Compare("sphere", shapes::Sphere(3));
  Compare("cube", shapes::Cube(20));
  Compare("torus", shapes::Torus(2.0, 1.0, 36, 12));  // 864 triangles, the thesis' number
  for (int level = 3; 20L << (2 * level) <= largest; ++level) Grow("sphere", shapes::Sphere(level));
  for (int n : {9, 29, 91, 289}) {
    if (12L * n * n <= largest) Grow("cube", shapes::Cube(n));
  }
  MachineNow();
}
