// SPDX-License-Identifier: Apache-2.0
#include "daemon/command/input.h"

#include <algorithm>

#include "calib/conf_scan.h"
#include "calib/make_view.h"
#include "calib/table_shift.h"
#include "core/base/error.h"
#include "core/base/printed.h"
#include "core/geometry/cloud_normals.h"
#include "core/geometry/sample_mesh.h"

namespace geond::daemon {
namespace fs = std::filesystem;

namespace {

constexpr int kPointsOfMesh = 30000;
constexpr double kTooSmall = 1e-3, kTooLarge = 20.0;  // m, across: no object for a turntable

void NoteOddSize(GeometryFile& file) {
  const std::vector<Eigen::Vector3d>& points = file.has_faces() ? file.mesh.vertices : file.cloud.points;
  if (points.empty()) return;
  const double across = BoundingBox(points).diagonal().norm();
  if (across >= kTooSmall && across <= kTooLarge) return;
  file.notes.push_back(
      Printed("the object is %.3g mm across: if that is wrong, say which unit its file is in with --unit", 1e3 * across));
}

}  // namespace

Input ReadInput(const fs::path& path, double meters_per_unit) {
  Input input;
  input.name = path.string();
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (!fs::exists(status)) throw FileError(path.string(), "open", "there is no such file or folder", "Check the path");
  if (fs::is_directory(status)) {
    if (!fs::exists(path / "scan.json", error)) {
      throw FileError(path.string(), "open", "the folder holds no scan.json",
                      "Give a recorded scan's folder, or a mesh or cloud file");
    }
    input.scan = ReadScan(path);
  } else if (path.filename() == "scan.json") {
    input.scan = ReadScan(path.parent_path());
  } else if (path.extension() == ".conf") {
    input.scan = calib::ReadConfScan(path);
  } else if (path.extension() == ".png") {
    throw FileError(path.string(), "open", "a range image alone does not say how its sensor sees",
                    "Give the folder of the recorded scan it belongs to");
  } else {
    input.file = Scaled(ReadGeometry(path), meters_per_unit);
    NoteOddSize(input.file);
  }
  return input;
}

void AddNotes(const Input& input, CommandResult& result) {
  result.json["notes"] = input.file.notes;
  for (const std::string& note : input.file.notes) result.text += "\n  note: " + note;
}

RegisteredViews ViewsOf(const RecordedScan& scan, const calib::RegisterOptions& options, std::stop_token stop,
                        const StepObserver& on_step) {
  RegisteredViews result;
  if (on_step) on_step("calibrate", 0, static_cast<int>(scan.views.size()));
  result.views = calib::MakeViews(scan, {}, options.threads);
  ThrowIfStopped(stop);
  const bool refined = std::all_of(scan.views.begin(), scan.views.end(),
                                   [](const RecordedScan::View& view) { return view.X_TS_refined.has_value(); });
  if (refined || result.views.size() < 2) return result;
  if (on_step) on_step("register", 0, 0);
  result.registration = calib::RegisterViews(result.views, options, stop, on_step);
  for (std::size_t i = 0; i < result.views.size(); ++i) result.views[i].X_TS = result.registration->X_TS[i];
  if (scan.has_table) calib::ShiftOntoTable(result.views);
  return result;
}

ObjectModel BuildModelOf(const Input& input, const ModelOptions& options, std::stop_token stop,
                         const StepObserver& on_step) {
  try {
    if (input.scan) {
      calib::RegisterOptions registering;
      registering.threads = options.charge.threads;
      RegisteredViews views = ViewsOf(*input.scan, registering, stop, on_step);
      ModelOptions with_table = options;
      with_table.tessellate.close_on_table = options.tessellate.close_on_table && input.scan->has_table;
      ObjectModel model = BuildObjectModel(views.views, with_table, stop, on_step);
      if (views.registration) {
        for (const std::string& note : views.registration->notes) model.description.notes.push_back(note);
      }
      return model;
    }
    ObjectModel model = input.is_mesh() ? BuildObjectModel(input.file.mesh, options, stop, on_step)
                                        : BuildObjectModel(input.file.cloud, options, stop, on_step);
    for (const std::string& note : input.file.notes) model.description.notes.push_back(note);
    return model;
  } catch (const std::invalid_argument& error) {
    throw FileError(input.name, "describe", error.what());
  }
}

const TriangleMesh& MeshOf(const Input& input) {
  if (!input.is_mesh()) {
    throw FileError(input.name, "read", "it has no faces, so it is no mesh", "Make one with `geon mesh`");
  }
  return input.file.mesh;
}

PointCloud PointsOf(const Input& input, std::stop_token stop, const StepObserver& on_step) {
  if (input.scan) return IntegrateViews(ViewsOf(*input.scan, {}, stop, on_step).views, {}, stop);
  if (input.is_mesh()) return SampleMesh(input.file.mesh, kPointsOfMesh);
  return WithOutwardNormals(input.file.cloud);
}

}  // namespace geond::daemon
