// SPDX-License-Identifier: Apache-2.0
#include "core/charge/fast.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>
#include <utility>

#include "core/base/parallel.h"
#include "core/charge/coarse.h"
#include "core/charge/far_field.h"
#include "core/charge/gmres.h"
#include "core/charge/interactions.h"
#include "core/charge/schwarz.h"
#include "core/charge/tree.h"

// The solver in order: an octree over the centroids (tree.h); who is near and who is far, by one dual traversal
// (interactions.h); the near pairs' integrals, computed once and held (near_field.h); the far pairs by multipoles,
// whose matrices are few because cells sit on a grid (far_field.h, harmonics.h); each leaf solved with its surroundings
// as preconditioner (schwarz.h), and the whole coarsely (coarse.h); flexible GMRES around it all (gmres.h). Single
// precision carries everything but the iteration itself until a tolerance below 5e-4 is asked for. Every sum is taken
// in an order that threads do not change.
namespace geond::charge {
namespace {

constexpr double kLeastSingleTolerance = 5e-4;  // below it single precision will not do on meshes of slivers

class Stopwatch {
 public:
  // Seconds since the last lap or the beginning.
  double Lap() {
    const auto now = std::chrono::steady_clock::now();
    return std::chrono::duration<double>(now - std::exchange(last_, now)).count();
  }

 private:
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

FastSettings InDoublePrecision(FastSettings settings) {
  settings.double_precision = true;
  settings.order.lowest = settings.order.highest = 10;
  settings.far.steepest = 0.43;
  settings.leaf_capacity = 64;
  settings.halo = 48;
  settings.near = {4.0, 1e9, 1e9};
  return settings;
}

template <typename Real>
UnitPotentialSolution Solve(const TriangleMesh& mesh, const Panels& panels, const FastSettings& settings, int threads,
                            const std::stop_token& stop, const StepObserver& on_step, FastReport& report,
                            const Kernels& kernels) {
  const std::size_t n = panels.size();
  const auto step = [&](const char* name, int done) {
    ThrowIfStopped(stop);
    if (on_step) on_step(name, done, 0);
  };
  Stopwatch total, phase;
  UnitPotentialSolution solution;

  step("charge: tree", 0);
  const Tree tree = BuildTree(mesh, panels, settings.leaf_capacity, threads);
  const Interactions interactions = FindInteractions(tree, settings.far, threads);
  report.tree_seconds = phase.Lap();
  step("charge: near field", 0);
  std::optional<NearField<Real>> held(std::in_place, mesh, panels, tree, interactions.near, settings.near, threads,
                                      kernels);
  if constexpr (sizeof(Real) == sizeof(float)) {
    if (held->thin_gap()) {
      held.reset();
      solution = Solve<double>(mesh, panels, InDoublePrecision(settings), threads, stop, on_step, report, kernels);
      solution.summary.message += ", in double precision, for surfaces that all but touch";
      return solution;
    }
  }
  const NearField<Real>& near = *held;
  report.near_seconds = phase.Lap();
  step("charge: far field", 0);
  const std::span<const RulePoint> rule =
      settings.double_precision ? std::span<const RulePoint>(kSevenPoints) : std::span<const RulePoint>(kThreePoints);
  FarField<Real> far(mesh, panels, tree, interactions.far, settings.order, rule, threads, kernels);
  report.far_seconds = phase.Lap();
  step("charge: preconditioner", 0);
  const SchwarzInverse inverse(panels, tree, interactions.near, near, settings.halo, threads, kernels);
  const CoarseInverse coarse(panels, tree, interactions, near, settings.coarse_triangles, threads, kernels);
  report.preconditioner_seconds = phase.Lap();

  report.cells = tree.cells.size();
  report.leaves = tree.leaves.size();
  report.near_pairs = near.pairs();
  report.exact_pairs = near.exact_pairs();
  report.far_pairs = interactions.far.source.size();
  report.matrices = far.matrices();
  report.far_multiplications = far.multiplications();
  report.near_bytes = near.bytes();
  report.far_bytes = far.bytes();
  report.preconditioner_bytes = inverse.bytes();
  solution.setup_seconds = total.Lap();

  step("charge: solve", 0);
  std::vector<Real> x_real(n);
  const LinearMap product = [&](std::span<const double> x, std::span<double> y) {
    Stopwatch watch;
    for (std::size_t i = 0; i < n; ++i) x_real[i] = static_cast<Real>(x[i]);
    far.Spread(x_real);
    ParallelFor(static_cast<std::ptrdiff_t>(tree.leaves.size()), threads, 16, [&](std::ptrdiff_t leaf) {
      const Cell& cell = tree.cells[tree.leaves[leaf]];
      std::vector<Real> potential(Padded(cell.count()), Real(0));
      near.AddPotential(static_cast<int>(leaf), x_real, potential.data());
      far.AddPotential(static_cast<int>(leaf), potential.data());
      for (int i = 0; i < cell.count(); ++i) y[cell.begin + i] = potential[i];
    });
    report.product_seconds += watch.Lap();
  };
  const LinearMap precondition = [&](std::span<const double> x, std::span<double> y) {
    inverse.Apply(x, y);
    coarse.Correct(x, y);
  };
  GmresOptions options;
  options.tolerance = settings.residual;
  options.max_iterations = 150;
  options.threads = threads;
  std::vector<double> shares(n);  // of the area
  double area = 0.0;
  for (double a : panels.area) area += a;
  for (std::size_t i = 0; i < n; ++i) shares[i] = panels.area[tree.order[i]] / area;
  options.weights = shares;
  options.error_tolerance = settings.error;
  const std::vector<double> ones(n, 1.0);
  GmresResult result = SolveGmres(product, precondition, ones, options, stop, [&](int iteration, double) {
    if (on_step) on_step("charge: solve", iteration, 0);
  });
  solution.x.resize(n);
  for (std::size_t i = 0; i < n; ++i) solution.x[tree.order[i]] = result.x[i];
  solution.solve_seconds = total.Lap();
  solution.peak_bytes = report.near_bytes + report.far_bytes + report.preconditioner_bytes +
                        tree.cells.size() * sizeof(Cell) + (result.summary.iterations + 4) * n * sizeof(double);
  solution.error_estimate = result.error_estimate;
  solution.summary = std::move(result.summary);
  solution.summary.seconds = solution.setup_seconds + solution.solve_seconds;
  return solution;
}

}  // namespace

// Measured against the exact matrix and, above 15,000 triangles, against a far finer solve (tests/validation/
// charge_accuracy_validation.cc).
FastSettings FastSettingsFor(double tolerance, std::size_t triangles) {
  FastSettings settings;
  settings.error = tolerance;
  settings.residual = 1e-6 * tolerance;
  settings.coarse_triangles = std::max(settings.coarse_triangles, static_cast<int>(triangles / 400));
  if (tolerance >= kLeastSingleTolerance) {
    settings.near = {1.8, 0.0, 8.0};
    return settings;
  }
  settings = InDoublePrecision(settings);
  if (tolerance < 1e-5) settings.order.lowest = settings.order.highest = 12;
  return settings;
}

UnitPotentialSolution SolveFast(const TriangleMesh& mesh, const Panels& panels, const FastSettings& settings,
                                int threads, const std::stop_token& stop, const StepObserver& on_step,
                                FastReport* report, const Kernels& kernels) {
  FastReport unread;
  FastReport& filled = report ? *report : unread;
  return settings.double_precision ? Solve<double>(mesh, panels, settings, threads, stop, on_step, filled, kernels)
                                   : Solve<float>(mesh, panels, settings, threads, stop, on_step, filled, kernels);
}

}  // namespace geond::charge
