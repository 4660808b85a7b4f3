// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "calib/register_views.h"
#include "core/geometry/mesh_files.h"
#include "core/object_model.h"
#include "core/range/scan_folder.h"
#include "daemon/command/command.h"

namespace geond::daemon {

// What a command was given: a geometry file (lengths in m by now) or a recorded scan.
struct Input {
  std::string name;                  // as given
  GeometryFile file;                 // empty if it is a scan
  std::optional<RecordedScan> scan;
  bool is_mesh() const { return !scan && file.has_faces(); }
};

// Reads a mesh, a cloud, the folder of a recorded scan (or its scan.json), or the .conf of a scan of range images as the
// Stanford repository has them. `meters_per_unit` is that of geometry files; .conf scans are in metres. Throws FileError.
// An object too small or too large for a scanner gets a note that names the unit.
Input ReadInput(const std::filesystem::path& path, double meters_per_unit);

// Adds to a result what was left out of a file or looks odd in it.
void AddNotes(const Input& input, CommandResult& result);

// The views of a scan in one frame: with the poses it holds if all are refined, else registered now.
struct RegisteredViews {
  std::vector<RangeView> views;
  std::optional<calib::RegistrationResult> registration;  // if it was done now
};
RegisteredViews ViewsOf(const RecordedScan& scan, const calib::RegisterOptions& options, std::stop_token stop,
                        const StepObserver& on_step);

// From whatever it is to the description. Throws FileError in one sentence if it cannot be meshed.
ObjectModel BuildModelOf(const Input& input, const ModelOptions& options, std::stop_token stop,
                         const StepObserver& on_step);

// The mesh of an input that must be one. Throws FileError.
const TriangleMesh& MeshOf(const Input& input);

// Points with outward normals (estimated if a cloud has none) of an input that is a cloud, a mesh (points spread over it) or
// a scan (its merged views).
PointCloud PointsOf(const Input& input, std::stop_token stop, const StepObserver& on_step);

}  // namespace geond::daemon
