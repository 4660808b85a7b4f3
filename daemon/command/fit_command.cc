// SPDX-License-Identifier: Apache-2.0
#include "core/base/printed.h"
#include "core/describe/description.h"
#include "core/describe/fit_json.h"
#include "core/empty_places.h"
#include "core/surface/integrate.h"
#include "daemon/command/input.h"
#include "daemon/command/offline_commands.h"

namespace geond::daemon {

CommandResult Fit(const FitArguments& arguments, const CommandContext& context) {
  const Input input = ReadInput(arguments.input, arguments.unit);
  std::vector<GeonFit> fits;
  try {
    Surroundings around;
    PointCloud part;
    if (input.scan) {   // the views say where the part is not
      const std::vector<RangeView> views = ViewsOf(*input.scan, {}, context.stop, context.on_step).views;
      part = IntegrateViews(views, {}, context.stop);
      around.empty = EmptyPlaces(views, input.scan->has_table, part);
    } else {
      part = PointsOf(input, context.stop, context.on_step);
    }
    fits = FitGeons(part, arguments.options, context.stop, context.on_step, around);
  } catch (const std::invalid_argument& error) {
    throw FileError(input.name, "fit", error.what());
  }
  CommandResult result;
  result.json = {{"best", GeonTypeName(fits.front().geon.type)},
                 {"confidence", fits.front().confidence},
                 {"margin", fits.front().margin},
                 {"fits", Json::array()}};
  for (const GeonFit& fit : fits) {
    const Geon& geon = fit.geon;
    const Eigen::Vector3d size = 1e3 * geon.size;
    const std::string name(GeonTypeName(geon.type));
    result.json["fits"].push_back({{"type", name},
                                   {"type_index", static_cast<int>(geon.type)},
                                   {"residual_mm", 1e3 * fit.residual},
                                   {"objective_mm", 1e3 * fit.objective},
                                   {"t1_mm", 1e3 * fit.t1},
                                   {"t2", fit.t2},
                                   {"pose", PoseJson(geon.X_TG)},
                                   {"size_mm", {size.x(), size.y(), size.z()}},
                                   {"taper", {geon.taper.x(), geon.taper.y()}},
                                   {"bend_per_mm", 1e-3 * geon.bend},
                                   {"size_at_least", SizesAtLeast(fit)},
                                   {"ends", EndsToJson(fit)},
                                   {"deviation", DeviationToJson(fit)},
                                   {"evaluations", fit.evaluations},
                                   {"seconds", fit.summary.seconds}});
    result.text += Printed("%s%-17s residual %7.4f mm, objective %7.4f mm, half sizes %s mm",
                          result.text.empty() ? "" : "\n", name.c_str(), 1e3 * fit.residual, 1e3 * fit.objective,
                          SizesInWords(fit, 2).c_str());
    if (IsTapered(geon.type)) result.text += Printed(", taper %.3f %.3f", geon.taper.x(), geon.taper.y());
    if (IsCurved(geon.type)) result.text += Printed(", bend %.5f /mm", 1e-3 * geon.bend);
  }
  AddNotes(input, result);
  return result;
}

}  // namespace geond::daemon
