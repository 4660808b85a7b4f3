// SPDX-License-Identifier: Apache-2.0
// Fig. 6.25: whole objects as geons.
#include "core/base/printed.h"
#include "core/model_picture.h"
#include "core/object_model.h"
#include "daemon/reproduce/experiments.h"
#include "daemon/reproduce/objects.h"
#include "daemon/reproduce/thesis_line.h"

namespace geond::reproduce {

Experiment MultiPartObjects(const Run& run) {
  Experiment e;
  e.title = "Fig. 6.25: objects of several parts as geons";
  e.what =
      "A cylinder with an ellipsoid on it and the pin from four views, the owl from one, each through the whole line. The thesis had the "
      "owl as two curved cylinders and a tapered cylinder (a carved stone, not ours). Repaired: exact charge on 1,000 triangles, traced "
      "boundaries, annealing on the triangles of each part.";
  struct Object {
    const char* key;
    const char* printed;
    sim::Scene scene;
    int views;
  };
  std::vector<Object> objects = {{"cylinder_ball", "cylinder + ellipsoid", CylinderAndBall(), 4},
                                 {"pin", "tapered cylinder + ellipsoid", BowlingPin(), 4},
                                 {"owl", "2 curved cylinders + tapered cylinder", Owl(), 1}};
  if (run.quick) objects.resize(1);
  using Better = Figure::Better;
  Table table{"What was found", {"object", "printed", "repaired", "today"}, {}};
  int done = 0, types_today = 0, types_repaired = 0, parts = 0;
  for (const Object& object : objects) {
    run.Progress("figure_6_25", done++, static_cast<int>(objects.size()));
    ScanSettings settings;
    settings.views = object.views;
    settings.seed = 25;
    const std::vector<RangeView> views = ScanViews(object.scene, settings, run);
    ModelOptions options;
    options.integrate.threads = options.tessellate.threads = options.charge.threads = options.fit.threads = run.threads;
    const ObjectModel model = BuildObjectModel(views, options, run.stop);
    TessellateOptions coarse;
    coarse.triangles = 1000;
    coarse.threads = run.threads;
    ViewMeshOptions view_options;
    view_options.step = 4;
    const TriangleMesh mesh = object.views > 1 ? Tessellate(views, model.cloud, coarse, run.stop)
                                               : Transform(views[0].X_TS, TessellateView(views[0], view_options));
    const ThesisModel thesis = RunThesisLine(mesh, object.views == 1, true, run);
    const std::vector<Geon> today = ChosenGeons(model.description), repaired = ChosenGeons(thesis);
    const auto n = static_cast<int>(object.scene.parts.size());
    const int right_today = TypesRight(object.scene, today), right_repaired = TypesRight(object.scene, repaired);
    types_today += right_today, types_repaired += right_repaired, parts += n;
    e.figures.push_back({std::string(object.key) + "_parts", Printed("%s: parts (built from %d)", object.scene.name.c_str(), n), "", 1.0 * n,
                         1.0 * thesis.parts.n_parts, 1.0 * model.segmentation.n_parts, Better::kSame, 0, 0, {}});
    e.figures.push_back({std::string(object.key) + "_types", object.scene.name + ": parts of the type they were built from", Printed("of %d", n), {},
                         1.0 * right_repaired, 1.0 * right_today, Better::kMore, 0, 0, {}});
    table.rows.push_back({object.scene.name, object.printed, NamesOf(repaired), NamesOf(today)});
    ObjectPictureOptions picture;
    picture.columns = 1300;
    picture.threads = run.threads;
    e.pictures.push_back({object.scene.name + ", today", ModelPicture(model, object.scene.name, picture)});
  }
  e.tables = {table};
  e.judgement = Printed("Today %d of %d parts get the type they were built from, by the thesis' line, repaired, %d.", types_today, parts, types_repaired);
  return e;
}

}  // namespace geond::reproduce
