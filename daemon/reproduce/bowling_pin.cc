// SPDX-License-Identifier: Apache-2.0
// Table 1.1: the description of the bowling pin.
#include <cmath>
#include <numbers>

#include "core/base/printed.h"
#include "core/model_picture.h"
#include "core/object_model.h"
#include "daemon/reproduce/experiments.h"
#include "daemon/reproduce/objects.h"
#include "daemon/reproduce/thesis_line.h"

namespace geond::reproduce {
namespace {

// The greatest relative error of a half size or, absolutely, of a taper, % ; none if a part or its type is missing.
std::optional<double> WorstError(const sim::Scene& scene, const std::vector<std::optional<Geon>>& matched) {
  double worst = 0.0;
  for (std::size_t i = 0; i < matched.size(); ++i) {
    const Geon truth = Canonical(scene.parts[i].geon);
    if (!matched[i] || matched[i]->type != truth.type) return {};
    for (int k = 0; k < 3; ++k) worst = std::max(worst, 100.0 * std::abs(matched[i]->size[k] / truth.size[k] - 1.0));
    if (IsTapered(truth.type)) worst = std::max(worst, 100.0 * (matched[i]->taper - truth.taper).cwiseAbs().maxCoeff());
  }
  return worst;
}

// Distance of the two centres, mm, and angle between the two axes, degrees.
std::optional<std::pair<double, double>> HowTheySit(const std::vector<std::optional<Geon>>& matched) {
  if (!matched[0] || !matched[1]) return {};
  const double distance = 1e3 * (matched[0]->X_TG.translation() - matched[1]->X_TG.translation()).norm();
  const double cosine = std::abs(matched[0]->X_TG.Rotate(Eigen::Vector3d::UnitZ()).dot(matched[1]->X_TG.Rotate(Eigen::Vector3d::UnitZ())));
  return std::pair(distance, 180.0 / std::numbers::pi * std::acos(std::min(1.0, cosine)));
}

}  // namespace

Experiment PinTable(const Run& run) {
  Experiment e;
  e.title = "Table 1.1: the bowling pin as two parametric geons";
  e.what =
      "A pin built from the printed sizes and tapers of Table 1.1 (its neck 3 mm lower than printed, for printed the two parts do not "
      "touch), scanned from four views with 0.2 mm of noise; so the printed numbers are the truth. Repaired: a mesh of 864 triangles, "
      "exact charge, traced boundaries, annealing on the triangles' centroids and normals. Today: the default line. Poses are "
      "compared by what does not depend on the frame: the distance of the centres and the angle of the axes.";
  const sim::Scene scene = BowlingPin();
  run.Progress("table_1_1", 0, 3);
  const std::vector<RangeView> views = ScanViews(scene, {}, run);
  run.Progress("table_1_1", 1, 3);
  ModelOptions options;
  options.integrate.threads = options.tessellate.threads = options.charge.threads = options.fit.threads = run.threads;
  const ObjectModel model = BuildObjectModel(views, options, run.stop);
  run.Progress("table_1_1", 2, 3);
  TessellateOptions coarse;
  coarse.triangles = 864;
  coarse.threads = run.threads;
  const ThesisModel thesis = RunThesisLine(Tessellate(views, model.cloud, coarse, run.stop), false, true, run);

  const std::vector<Geon> found_today = ChosenGeons(model.description), found_thesis = ChosenGeons(thesis);
  const auto today = MatchedParts(scene, found_today), repaired = MatchedParts(scene, found_thesis);
  using Better = Figure::Better;
  e.figures = {{"parts", "parts", "", 2.0, 1.0 * thesis.parts.n_parts, 1.0 * model.segmentation.n_parts, Better::kSame, 0, 0, {}},
               {"types", "parts of the right type", "of 2", 2.0, 1.0 * TypesRight(scene, found_thesis), 1.0 * TypesRight(scene, found_today),
                Better::kMore, 0, 0, 2.0}};
  const auto size = [](const std::optional<Geon>& geon, int k) { return geon ? std::optional(1e3 * geon->size[k]) : std::nullopt; };
  const auto taper = [](const std::optional<Geon>& geon, int k) { return geon ? std::optional(geon->taper[k]) : std::nullopt; };
  const char* const axes = "xyz";
  for (std::size_t part = 0; part < 2; ++part) {
    const Geon truth = Canonical(scene.parts[part].geon);
    for (int k = 0; k < 3; ++k) {
      e.figures.push_back({Printed("%s_a%c", scene.parts[part].name.c_str(), axes[k]), Printed("%s, half size a_%c", scene.parts[part].name.c_str(), axes[k]),
                           "mm", 1e3 * truth.size[k], size(repaired[part], k), size(today[part], k), Better::kSame, 0.02, 0.2, {}});
    }
  }
  const Geon neck = Canonical(scene.parts[1].geon);
  for (int k = 0; k < 2; ++k) {
    e.figures.push_back({Printed("neck_k%c", axes[k]), Printed("neck, taper k_%c", axes[k]), "", neck.taper[k], taper(repaired[1], k), taper(today[1], k),
                         Better::kSame, 0, 0.02, {}});
  }
  std::vector<std::optional<Geon>> truth;
  for (const auto& part : scene.parts) truth.emplace_back(Canonical(part.geon));
  const auto true_sit = HowTheySit(truth), thesis_sit = HowTheySit(repaired), today_sit = HowTheySit(today);
  const auto first = [](const auto& pair) { return pair ? std::optional(pair->first) : std::nullopt; };
  const auto second = [](const auto& pair) { return pair ? std::optional(pair->second) : std::nullopt; };
  e.figures.push_back({"distance", "distance of the two centres (printed: 59.1)", "mm", first(true_sit), first(thesis_sit), first(today_sit), Better::kSame, 0.01, 0.2, {}});
  e.figures.push_back({"angle", "angle between the two axes (printed: about 7, built as 0)", "degrees", second(true_sit), second(thesis_sit), second(today_sit), Better::kLess, 0, 1.0, {}});
  e.figures.push_back({"worst", "largest error of a size (%) or a taper (hundredths)", "%", {}, WorstError(scene, repaired), WorstError(scene, today), Better::kLess, 0.2, 0.5, {}});
  e.tables = {{"What was found", {"", "parts"}, {{"thesis", "ellipsoid + tapered cylinder"},
                                                 {"its algorithm, repaired", NamesOf(found_thesis)}, {"today", NamesOf(found_today)}}}};
  ObjectPictureOptions picture;
  picture.columns = 1500;
  picture.threads = run.threads;
  e.pictures = {{"Today: points, mesh by charge, parts, geons over the points", ModelPicture(model, "bowling pin", picture)}};
  ObjectPictureData data;
  data.mesh = thesis.mesh;
  data.charge = thesis.density;
  data.labels = thesis.parts.labels;
  picture.columns = 900;
  e.pictures.push_back({"The thesis' algorithm, repaired: 864 triangles by charge, and the parts it traced", ObjectPicture(data, picture)});
  const std::optional<double> worst = WorstError(scene, today);
  e.judgement = Printed("Today the table comes back from the scan%s; the thesis' line, repaired, gives %d part%s (%s).",
                     worst ? Printed(" with no size or taper off by more than %.1f %%", *worst).c_str() : " in part only",
                     thesis.parts.n_parts, thesis.parts.n_parts == 1 ? "" : "s", NamesOf(found_thesis).c_str());
  return e;
}

}  // namespace geond::reproduce
