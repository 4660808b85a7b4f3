// SPDX-License-Identifier: Apache-2.0
#include "core/charge/charge_density.h"

#include <cmath>
#include <stdexcept>
#include <string>

#include "core/charge/dense.h"
#include "core/charge/panels.h"

namespace geond {
namespace {

constexpr std::size_t kMostDense = 6000;  // triangles: 288 MB

}  // namespace

ChargeDensity SolveChargeDensity(const TriangleMesh& mesh, const ChargeOptions& options, std::stop_token stop,
                                 const StepObserver& on_step) {
  if (!(options.tolerance > 0.0)) throw std::invalid_argument("the tolerance of the charge must be positive");
  ThrowIfStopped(stop);
  const charge::Panels panels = charge::MakePanels(mesh);
  if (panels.size() > kMostDense) {
    throw std::invalid_argument("the mesh has " + std::to_string(panels.size()) + " triangles, the exact solve takes " +
                                std::to_string(kMostDense) + ": remesh it more coarsely");
  }
  charge::UnitPotentialSolution unit =
      charge::SolveDense(mesh, panels, charge::DenseMethod::kGmres, options.threads, stop, on_step);

  ChargeDensity result;
  for (std::size_t i = 0; i < panels.size(); ++i) result.capacitance += unit.x[i] * panels.area[i];
  result.potential = 1.0 / result.capacitance;
  result.density = std::move(unit.x);
  for (double& value : result.density) value *= result.potential;
  result.solver = ChargeOptions::Solver::kDense;
  result.setup_seconds = unit.setup_seconds;
  result.solve_seconds = unit.solve_seconds;
  result.peak_bytes = unit.peak_bytes;
  result.summary = std::move(unit.summary);
  return result;
}

}  // namespace geond
