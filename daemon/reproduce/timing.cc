// SPDX-License-Identifier: Apache-2.0
// What the thesis says of time: 80 s for the charge on 864 triangles, three minutes for a fit.
#include <cmath>
#include <ctime>

#include "core/base/printed.h"
#include "daemon/reproduce/experiments.h"
#include "daemon/reproduce/objects.h"
#include "daemon/reproduce/scans.h"
#include "core/charge/charge_density.h"

namespace geond::reproduce {
namespace {

// Processor seconds, all threads together, of one call: the least of `repeats`.
template <typename Work>
double CpuSeconds(int repeats, const Work& work) {
  double least = 1e300;
  for (int i = 0; i < repeats; ++i) {
    const std::clock_t begin = std::clock();
    work();
    least = std::min(least, static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC);
  }
  return least;
}

}  // namespace

Experiment Timing(const Run& run) {
  Experiment e;
  e.title = "Sections 6.3 and 6.5: times";
  e.what =
      "Processor seconds, the least of several runs, on this machine: charge on the pin's mesh and on finer ones, the seven models fitted "
      "to 400 points. The thesis' machines were an SGI R8000 (charge) and R4000 (fits) of the nineties, so the factor is the machine's as "
      "well as the method's.";
  using Better = Figure::Better;
  using Solver = ChargeOptions::Solver;
  Series dense{"exact dense solve", {}, {}, Series::Kind::kLineAndMarks}, usual{"default", {}, {}, Series::Kind::kLineAndMarks};
  Series thesis{"thesis, 1996", {864}, {80}, Series::Kind::kMarks};
  const std::vector<int> sizes = run.quick ? std::vector<int>{864, 1300} : std::vector<int>{864, 2000, 5000, 10000};
  double dense_864 = 0.0, usual_864 = 0.0;
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    run.Progress("timing", static_cast<int>(i), static_cast<int>(sizes.size()) + 1);
    const TriangleMesh mesh = MeshOfUnion(BowlingPin(), sizes[i], run.threads, run.stop).mesh;
    const auto solve = [&](Solver solver) {
      ChargeOptions options;
      options.solver = solver;
      options.threads = 1;
      return CpuSeconds(i < 2 ? 3 : 1, [&] { SolveChargeDensity(mesh, options, run.stop); });
    };
    const auto n = static_cast<double>(mesh.triangles.size());
    dense.x.push_back(n), usual.x.push_back(n);
    dense.y.push_back(solve(Solver::kDense)), usual.y.push_back(solve(Solver::kAuto));
    if (i == 0) dense_864 = dense.y[0], usual_864 = usual.y[0];
  }
  run.Progress("timing", static_cast<int>(sizes.size()), static_cast<int>(sizes.size()) + 1);
  const PointCloud cloud = ThinnedCloud(ScanViews(SevenObjects()[6], {}, run), 400, run);
  Run one = run;
  one.threads = 1;
  const double annealing = CpuSeconds(1, [&] { FitByAnnealing(cloud, {}, 1, one); });
  const double by_default = CpuSeconds(3, [&] { FitByDefault(cloud, one); });
  e.figures = {{"charge_864", Printed("charge on %.0f triangles", dense.x[0]), "CPU s", 80.0, dense_864, usual_864, Better::kFree, 0, 0, {}},
               {"fit", "one model fitted to one part", "CPU s", 180.0, annealing / 7.0, by_default / 7.0, Better::kFree, 0, 0, {}},
               {"fit_all", "all seven models", "CPU s", {}, annealing, by_default, Better::kFree, 0, 0, {}},
               {"growth", Printed("growth of the time of charge with triangles, exponent from %.0f to %.0f", dense.x[0], dense.x.back()), "", 2.0,
                std::log(dense.y.back() / dense.y[0]) / std::log(dense.x.back() / dense.x[0]),
                std::log(usual.y.back() / usual.y[0]) / std::log(usual.x.back() / usual.x[0]), Better::kFree, 0, 0, {}}};
  e.plots = {{"Time of the charge over triangles", {"triangles", true}, {"processor seconds", true}, {dense, usual, thesis}}};
  e.judgement = Printed("80 s have become %.2f s for the same exact solve and %.2f s by default, three minutes for a model %.3f s; the thesis' O(N^2) is the "
                     "matrix alone: the exact solve's time grows by the power %.1f here, the default's by %.1f.", dense_864, usual_864, by_default / 7.0,
                     *e.figures[3].repaired, *e.figures[3].today);
  return e;
}

}  // namespace geond::reproduce
