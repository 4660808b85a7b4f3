// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "core/base/printed.h"
#include "core/charge/potential_spread.h"
#include "daemon/command/input.h"
#include "daemon/command/offline_commands.h"

namespace geond::daemon {
namespace {

std::string_view SolverName(ChargeOptions::Solver solver) {
  return solver == ChargeOptions::Solver::kDense ? "dense" : solver == ChargeOptions::Solver::kFast ? "fast" : "auto";
}

}  // namespace

CommandResult Charge(const ChargeArguments& arguments, const CommandContext& context) {
  const Input input = ReadInput(arguments.input, arguments.unit);
  const TriangleMesh& mesh = MeshOf(input);
  ChargeDensity charge;
  try {
    charge = SolveChargeDensity(mesh, arguments.options, context.stop, context.on_step);
  } catch (const std::invalid_argument& error) {
    throw FileError(input.name, "charge", error.what());
  }
  std::vector<double> density_per_mm2 = charge.density;
  for (double& density : density_per_mm2) density *= 1e-6;
  if (!arguments.output.empty()) {
    GeometryFile file;
    file.mesh = mesh;
    WriteMesh(Scaled(std::move(file), 1.0 / arguments.unit).mesh, arguments.output, {{"charge", density_per_mm2}});
  }
  // A small part of the work of the solve.
  const int samples = static_cast<int>(std::clamp<std::size_t>(200'000'000 / mesh.triangles.size(), 16, 1000));
  const double spread = PotentialSpread(mesh, charge, 1, samples).relative_rms;
  CommandResult result;
  result.json = {{"n_triangles", mesh.triangles.size()},
                 {"capacitance_mm", 1e3 * charge.capacitance},
                 {"potential_spread", spread},
                 {"iterations", charge.summary.iterations},
                 {"residual", charge.summary.residual},
                 {"error_estimate", charge.error_estimate},
                 {"near_pairs", charge.near_pairs},
                 {"n_negative", charge.negative},
                 {"converged", charge.summary.converged},
                 {"solver", SolverName(charge.solver)},
                 {"seconds",
                  {{"setup", charge.setup_seconds},
                   {"solve", charge.solve_seconds},
                   {"tree", charge.seconds.tree},
                   {"near", charge.seconds.near},
                   {"far", charge.seconds.far},
                   {"preconditioner", charge.seconds.preconditioner},
                   {"products", charge.seconds.products}}},
                 {"peak_memory_mb", static_cast<double>(charge.peak_bytes) / 1e6}};
  const auto [least, greatest] = std::minmax_element(density_per_mm2.begin(), density_per_mm2.end());
  result.text = Printed("%zu triangles, capacitance %.6g mm, density %.4g to %.4g /mm^2, potential even to %.2g %% "
                       "(solver %s, %.2f s)%s",
                       mesh.triangles.size(), 1e3 * charge.capacitance, *least, *greatest, 100.0 * spread,
                       std::string(SolverName(charge.solver)).c_str(), charge.setup_seconds + charge.solve_seconds,
                       charge.summary.converged ? "" : ("; NOT CONVERGED: " + charge.summary.message).c_str());
  result.json["density"] = std::move(density_per_mm2);
  AddNotes(input, result);
  return result;
}

}  // namespace geond::daemon
