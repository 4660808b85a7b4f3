// SPDX-License-Identifier: Apache-2.0
// Table 6.1 and Fig. 6.17: each of the seven models fitted to each of seven geon-like objects.
#include <algorithm>
#include <limits>

#include "core/base/printed.h"
#include "daemon/reproduce/experiments.h"
#include "daemon/reproduce/objects.h"
#include "daemon/reproduce/scans.h"

namespace geond::reproduce {
namespace {

constexpr double kPrinted[7][7] = {
    {1.206, 12.075, 19.368, 16.511, 26.449, 14.512, 24.162}, {22.535, 0.7968, 12.976, 0.864, 12.834, 0.871, 14.432},
    {36.156, 17.819, 1.313, 28.707, 1.327, 17.807, 1.338},   {17.993, 20.740, 27.190, 2.339, 15.203, 17.625, 25.740},
    {34.276, 28.241, 14.256, 20.156, 1.667, 28.228, 14.242}, {24.153, 21.986, 22.148, 21.197, 47.987, 3.300, 22.197},
    {34.209, 29.887, 23.213, 25.130, 16.291, 14.341, 2.949}};

using Residuals = std::array<std::array<double, 7>, 7>;  // object, model; mm

struct Verdict {
  int diagonals = 0;          // rows whose least residual is their own model's, models that contain it apart
  double least_ratio = std::numeric_limits<double>::infinity();  // of another model's residual to the own one's
  std::array<double, 7> row_ratio;
};

Verdict Judge(const Residuals& residuals) {
  Verdict verdict;
  for (int row = 0; row < 7; ++row) {
    double least = std::numeric_limits<double>::infinity();
    for (int model = 0; model < 7; ++model) {
      if (model == row || Contains(kGeonTypes[model], kGeonTypes[row])) continue;
      least = std::min(least, residuals[row][model] / residuals[row][row]);
    }
    verdict.row_ratio[row] = least;
    verdict.diagonals += least > 1.0;
    verdict.least_ratio = std::min(verdict.least_ratio, least);
  }
  return verdict;
}

Table ResidualTable(const std::string& caption, const Residuals& residuals) {
  Table table{caption, {"object"}, {}};
  for (int model = 0; model < 7; ++model) table.heads.push_back(Printed("%d", model + 1));
  for (int row = 0; row < 7; ++row) {
    std::vector<std::string> cells{Printed("%d ", row + 1) + PlainName(kGeonTypes[row])};
    for (int model = 0; model < 7; ++model) {
      const std::string number = Printed("%.3f", residuals[row][model]);
      const bool nested = Contains(kGeonTypes[model], kGeonTypes[row]);
      cells.push_back(model == row ? "*" + number : nested ? "(" + number + ")" : number);
    }
    table.rows.push_back(cells);
  }
  return table;
}

}  // namespace

Experiment GeonTable(const Run& run) {
  Experiment e;
  e.title = "Table 6.1 and Fig. 6.17: seven models fitted to seven geon-like objects";
  e.what =
      "Seven objects of one geon each, scanned from four views (0.2 mm noise), normals by plane fits, registered, integrated and "
      "thinned to 400 points. Each model is fitted to each; the residual is E = t1 + 5 gamma t2 (5.18). Repaired: very fast "
      "re-annealing alone with the settings of section 6.2, one run a cell, the least residual wins. Today: many starts refined by "
      "Levenberg-Marquardt, a deformed winner gives way to its base shape if that is as good to 10 %. Residuals in brackets are "
      "those of models that contain the object's own (underlined in the thesis). Our objects differ in size from the thesis'.";
  const std::vector<sim::Scene> objects = SevenObjects();
  const int seeds = run.quick ? 1 : 5;
  Residuals annealed{}, today{}, printed{};
  int types_annealed = 0, types_today = 0, runs = 0, reached = 0;
  for (int row = 0; row < 7; ++row) {
    run.Progress("table_6_1", row, 7);
    ScanSettings settings;
    settings.seed = static_cast<std::uint64_t>(row) + 1;
    const PointCloud cloud = ThinnedCloud(ScanViews(objects[row], settings, run), 400, run);
    const SevenFits by_default = FitByDefault(cloud, run);
    for (int seed = 1; seed <= seeds; ++seed) {
      const SevenFits fits = FitByAnnealing(cloud, {}, static_cast<std::uint64_t>(seed), run);
      ++runs;
      reached += fits.fits[row].objective <= 1.05 * by_default.fits[row].objective;
      if (seed > 1) continue;
      types_annealed += fits.chosen == row;
      for (int model = 0; model < 7; ++model) annealed[row][model] = 1e3 * fits.fits[model].objective;
      if (row == 6) {
        for (int model = 0; model < 7; ++model) {
          e.pictures.push_back({Printed("Curved cuboid, %s: E %.2f mm today (shown), %.2f mm by annealing, %.2f mm in Fig. 6.17",
                                     PlainName(kGeonTypes[model]).c_str(), 1e3 * by_default.fits[model].objective,
                                     1e3 * fits.fits[model].objective, kPrinted[6][model]),
                                FitPicture(by_default.fits[model].geon, cloud, run)});
        }
      }
    }
    types_today += by_default.chosen == row;
    for (int model = 0; model < 7; ++model) {
      today[row][model] = 1e3 * by_default.fits[model].objective;
      printed[row][model] = kPrinted[row][model];
    }
  }
  const Verdict of_print = Judge(printed), of_annealing = Judge(annealed), of_today = Judge(today);
  using Better = Figure::Better;
  e.figures = {
      {"diagonal_least", "rows whose least residual is on the diagonal (containing models apart)", "of 7", 1.0 * of_print.diagonals,
       1.0 * of_annealing.diagonals, 1.0 * of_today.diagonals, Better::kMore, 0, 0, 7.0},
      {"least_ratio", "least ratio of another model's residual to the own one's", "", of_print.least_ratio, of_annealing.least_ratio,
       of_today.least_ratio, Better::kMore, 0.1, 0, 4.0},
      {"types_right", "objects whose own type is chosen", "of 7", 7.0, 1.0 * types_annealed, 1.0 * types_today, Better::kMore, 0, 0, 7.0},
      {"optimum_reached", Printed("own-type runs of annealing within 5 %% of the best known residual, %d runs", runs),
       "%", {}, 100.0 * reached / runs, {}, Better::kMore, 0, 15, {}},
  };
  for (int row = 0; row < 7; ++row) {
    e.figures.push_back({Printed("row_%d", row + 1), "least ratio in the row of the " + PlainName(kGeonTypes[row]), "", of_print.row_ratio[row],
                         of_annealing.row_ratio[row], of_today.row_ratio[row], Better::kMore, 0.15, 0, {}});
  }
  e.tables = {ResidualTable("Today: residuals E in mm, model 1 to 7", today),
              ResidualTable("The thesis' algorithm, repaired: E in mm after one run of annealing a cell", annealed),
              ResidualTable("As printed in Table 6.1", printed)};
  e.judgement = Printed(
      "The objective does discriminate as printed: with optima found, every own model wins by a factor of %.1f or more (printed: "
      "%.1f). But one run of annealing with the printed settings reaches the optimum in %d of %d own-type runs and chooses %d of 7 "
      "types; the thesis' table needs more runs or more time than it says.",
      of_today.least_ratio, of_print.least_ratio, reached, runs, types_annealed);
  return e;
}

}  // namespace geond::reproduce
