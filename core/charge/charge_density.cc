// SPDX-License-Identifier: Apache-2.0
#include "core/charge/charge_density.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "core/charge/dense.h"
#include "core/charge/fast.h"
#include "core/charge/one_sign.h"
#include "core/charge/panels.h"

namespace geond {
namespace {

constexpr std::size_t kDenseByItself = 500;  // triangles up to which the exact matrix is chosen: it is no slower
constexpr std::size_t kMostDense = 30000;     // up to which it is made at all: 7.2 GB

ChargeOptions::Solver Choose(const ChargeOptions& options, std::size_t triangles) {
  using Solver = ChargeOptions::Solver;
  Solver solver = options.solver;
  if (solver == Solver::kAuto) {
    solver = triangles <= kDenseByItself || options.tolerance < charge::kLeastFastTolerance ? Solver::kDense : Solver::kFast;
  }
  if (solver == Solver::kDense && triangles > kMostDense) {
    throw std::invalid_argument("the exact solve takes up to " + std::to_string(kMostDense) + " triangles and the mesh has " +
                                std::to_string(triangles) + ": use the fast solver with a tolerance of 1e-6 or more, or "
                                "remesh more coarsely");
  }
  if (solver == Solver::kFast && options.tolerance < charge::kLeastFastTolerance) {
    throw std::invalid_argument("the fast charge solver reaches a tolerance of 1e-6: ask for that, or for the exact solve");
  }
  return solver;
}

}  // namespace

ChargeDensity SolveChargeDensity(const TriangleMesh& mesh, const ChargeOptions& options, std::stop_token stop,
                                 const StepObserver& on_step) {
  if (!(options.tolerance > 0.0)) throw std::invalid_argument("the tolerance of the charge must be positive");
  ThrowIfStopped(stop);
  const charge::Panels panels = charge::MakePanels(mesh);
  const ChargeOptions::Solver solver = Choose(options, panels.size());
  ChargeDensity result;
  charge::UnitPotentialSolution unit;
  if (solver == ChargeOptions::Solver::kDense) {
    unit = charge::SolveDense(mesh, panels, charge::DenseMethod::kGmres, options.threads, stop, on_step);
    result.seconds.near = unit.setup_seconds;
    result.seconds.products = unit.solve_seconds;
    result.near_pairs = panels.size() * panels.size();
  } else {
    charge::FastReport report;
    unit = charge::SolveFast(mesh, panels, charge::FastSettingsFor(options.tolerance, panels.size()), options.threads, stop,
                             on_step, &report);
    result.seconds = {report.tree_seconds, report.near_seconds, report.far_seconds, report.preconditioner_seconds,
                      report.product_seconds};
    result.near_pairs = report.near_pairs;
  }
  for (std::size_t i = 0; i < panels.size(); ++i) result.capacitance += unit.x[i] * panels.area[i];
  result.potential = 1.0 / result.capacitance;
  result.density = std::move(unit.x);
  for (double& value : result.density) value *= result.potential;
  result.negative = options.one_sign
                        ? charge::MakeOneSign(mesh, panels.area, result.density)
                        : std::count_if(result.density.begin(), result.density.end(), [](double d) { return d < 0.0; });
  result.solver = solver;
  result.setup_seconds = unit.setup_seconds;
  result.solve_seconds = unit.solve_seconds;
  result.peak_bytes = unit.peak_bytes;
  result.error_estimate = unit.error_estimate;
  result.summary = std::move(unit.summary);
  return result;
}

}  // namespace geond
