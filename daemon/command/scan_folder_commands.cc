// SPDX-License-Identifier: Apache-2.0
#include "calib/make_view.h"
#include "core/base/printed.h"
#include "daemon/command/input.h"
#include "daemon/command/offline_commands.h"

namespace geond::daemon {
namespace {

Input ReadScanInput(const std::filesystem::path& path, double meters_per_unit) {
  Input input = ReadInput(path, meters_per_unit);
  if (!input.scan) {
    throw FileError(path.string(), "read", "it is no recorded scan",
                    "Give the folder of a scan (with scan.json) or the .conf of one");
  }
  return input;
}

std::string_view ModelName(calib::RegisterOptions::Model model) {
  switch (model) {
    case calib::RegisterOptions::Model::kAuto: return "auto";
    case calib::RegisterOptions::Model::kTurntable: return "turntable";
    case calib::RegisterOptions::Model::kFree: return "free";
    case calib::RegisterOptions::Model::kNone: return "none";
  }
  return "none";
}

}  // namespace

CommandResult Register(const RegisterArguments& arguments, const CommandContext& context) {
  const Stopwatch watch;
  Input input = ReadScanInput(arguments.input, arguments.unit);
  RecordedScan& scan = *input.scan;
  calib::RegistrationResult registration;
  try {
    const std::vector<RangeView> views = calib::MakeViews(scan, {}, arguments.options.threads);
    registration = calib::RegisterViews(views, arguments.options, context.stop, context.on_step);
  } catch (const std::invalid_argument& error) {
    throw FileError(input.name, "register", error.what());
  }
  for (std::size_t i = 0; i < scan.views.size(); ++i) scan.views[i].X_TS_refined = registration.X_TS[i];
  if (!arguments.output.empty()) WriteScan(scan, arguments.output);

  CommandResult result;
  result.json["views"] = Json::array();
  for (const Pose& X_TS : registration.X_TS) result.json["views"].push_back({{"X_TS", PoseJson(X_TS)}});
  result.json["rms_mm"] = 1e3 * registration.rms_after;
  result.json["rms_before_mm"] = 1e3 * registration.rms_before;
  result.json["model"] = ModelName(registration.model);
  result.json["iterations"] = registration.summary.iterations;
  result.json["converged"] = registration.summary.converged;
  result.json["notes"] = registration.notes;
  result.json["seconds"] = watch.seconds();
  result.text = Printed("%zu views, rms %.4f mm before, %.4f mm after, %d iterations", registration.X_TS.size(),
                       1e3 * registration.rms_before, 1e3 * registration.rms_after, registration.summary.iterations);
  for (const std::string& note : registration.notes) result.text += "\n  " + note;
  return result;
}

CommandResult Merge(const MergeArguments& arguments, const CommandContext& context) {
  const Stopwatch watch;
  const Input input = ReadScanInput(arguments.input, arguments.unit);
  PointCloud merged;
  std::size_t n_in = 0;
  try {
    const std::vector<RangeView> views = ViewsOf(*input.scan, {}, context.stop, context.on_step).views;
    for (const RangeView& view : views) n_in += ViewCloud(view).size();
    if (context.on_step) context.on_step("integrate", 0, 0);
    merged = IntegrateViews(views, arguments.options, context.stop);
  } catch (const std::invalid_argument& error) {
    throw FileError(input.name, "merge", error.what());
  }
  GeometryFile file;
  file.cloud = merged;
  WriteCloud(Scaled(std::move(file), 1.0 / arguments.unit).cloud, arguments.output);
  return {Json{{"n_points_in", n_in}, {"n_points_out", merged.size()}, {"seconds", watch.seconds()}},
          Printed("%zu points of %zu kept, in %s", merged.size(), n_in, arguments.output.c_str())};
}

}  // namespace geond::daemon
