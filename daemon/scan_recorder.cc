// SPDX-License-Identifier: Apache-2.0
// A scan's folder holds, in the order they come to be: journal.json (what was asked for), view_000.exposure and so on,
// then scan.json with its images, cloud.ply, mesh.ply, picture.png, and last description.json; then the exposures go.
// outcome.json says why there is no description, the file "pinned" that the scan is to be kept. Each of them is whole
// or not there, whenever the power goes: what is written under its own name is synced before description.json says so.
#include "daemon/scan_recorder.h"

#include <utility>

#include <nlohmann/json.hpp>

#include "core/base/error.h"
#include "core/base/printed.h"
#include "core/geometry/mesh_files.h"
#include "core/model_picture.h"
#include "daemon/durable_file.h"
#include "daemon/exposure_file.h"

namespace geond::daemon {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

fs::path ViewFile(const fs::path& folder, int view) { return folder / Printed("view_%03d.exposure", view); }

json ReadJson(const fs::path& path) {
  json value = json::parse(ReadWhole(path), nullptr, false);
  if (!value.is_object()) throw FileError(path.string(), "parse", "it is not a JSON object", "Delete the scan");
  return value;
}

std::chrono::system_clock::time_point WrittenAt(const fs::path& path) {
  return std::chrono::system_clock::time_point(std::chrono::seconds(ModifiedAt(path)));
}

// Fills in what the files say.
void ReadFiles(const fs::path& folder, ScanSummary& scan) {
  const json journal = ReadJson(folder / "journal.json");
  scan.views = journal.value("views", 0);
  scan.first_angle = journal.value("first_angle_rad", 0.0);
  scan.label = journal.value("label", "");
  scan.ended = WrittenAt(folder / "journal.json");
  if (fs::exists(folder / "description.json")) {
    const json description = ReadJson(folder / "description.json");
    for (const json& part : description.at("parts")) scan.types.push_back(part.at("type"));
    scan.state = ScanState::kDone;
    scan.views_taken = scan.views;
    scan.ended = WrittenAt(folder / "description.json");
    return;
  }
  while (fs::exists(ViewFile(folder, scan.views_taken))) {
    scan.ended = WrittenAt(ViewFile(folder, scan.views_taken));
    ++scan.views_taken;
  }
  if (fs::exists(folder / "outcome.json")) {
    const json outcome = ReadJson(folder / "outcome.json");
    scan.state =
        outcome.value("state", "") == ScanStateName(ScanState::kCancelled) ? ScanState::kCancelled : ScanState::kFailed;
    scan.error = outcome.value("error", "");
    scan.ended = WrittenAt(folder / "outcome.json");
  }
}

}  // namespace

std::string_view ScanStateName(ScanState state) {
  switch (state) {
    case ScanState::kRunning:
      return "running";
    case ScanState::kInterrupted:
      return "interrupted";
    case ScanState::kFailed:
      return "failed";
    case ScanState::kCancelled:
      return "cancelled";
    case ScanState::kDone:
      return "done";
  }
  return "interrupted";
}

ScanSummary ReadSummary(const fs::path& folder, int id) {
  ScanSummary scan;
  scan.id = id;
  scan.state = ScanState::kInterrupted;
  try {
    ReadFiles(folder, scan);
  } catch (const std::exception& error) {
    scan.state = ScanState::kFailed;
    scan.types.clear();
    scan.error = error.what();
  }
  std::error_code ignored;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, ignored)) {
    if (const std::uintmax_t size = entry.file_size(ignored); !ignored) scan.bytes += size;
  }
  scan.pinned = fs::exists(folder / "pinned", ignored);
  return scan;
}

void ScanRecorder::KeepPlan(int views, double first_angle, const std::string& label) const {
  WriteDurably(
      folder_ / "journal.json",
      json{{"views", views}, {"first_angle_rad", first_angle}, {"label", label}, {"software", GEOND_VERSION}}.dump(
          2, ' ', false, json::error_handler_t::replace));
}

void ScanRecorder::KeepView(int view, const Exposure& exposure) const {
  WriteDurably(ViewFile(folder_, view), EncodeExposure(exposure));
}

void ScanRecorder::Finish(const RecordedScan& scan, const ObjectModel& model, bool picture) const {
  WriteScan(scan, folder_);
  WriteCloud(model.cloud, folder_ / "cloud.ply");
  WriteMesh(model.mesh, folder_ / "mesh.ply",
            {{"charge", model.charge.density},
             {"part", {model.segmentation.labels.begin(), model.segmentation.labels.end()}}});
  if (picture) WritePng(ModelPicture(model), folder_ / "picture.png");
  for (const fs::directory_entry& entry : fs::directory_iterator(folder_)) {
    if (entry.is_regular_file()) SyncFile(entry.path());
  }
  // Their names too must be safe before the description says that they are there.
  SyncFolder(folder_);
  WriteDurably(folder_ / "description.json", ToJson(model.description));
  Tidy();
}

void ScanRecorder::KeepGrasps(const std::string& grasps) const { WriteDurably(folder_ / "grasps.json", grasps); }

void ScanRecorder::Abandon(ScanState state, const std::string& error) const {
  WriteDurably(folder_ / "outcome.json", json{{"state", ScanStateName(state)}, {"error", error}}.dump(
                                             2, ' ', false, json::error_handler_t::replace));
}

void ScanRecorder::Pin(bool pinned) const {
  if (pinned) {
    WriteDurably(folder_ / "pinned", "");
    return;
  }
  std::error_code error;
  fs::remove(folder_ / "pinned", error);
  if (error) throw FileError((folder_ / "pinned").string(), "remove", error.message(), "Check the permissions");
  SyncFolder(folder_);
}

std::vector<Exposure> ScanRecorder::Views() const {
  std::vector<Exposure> exposures;
  for (int view = 0; fs::exists(ViewFile(folder_, view)); ++view) {
    try {
      exposures.push_back(DecodeExposure(ReadWhole(ViewFile(folder_, view)), ViewFile(folder_, view).string()));
    } catch (const FileError&) {
      break;  // it and those after it are taken again
    }
  }
  return exposures;
}

void ScanRecorder::Tidy() const noexcept {
  std::error_code ignored;
  const bool done = fs::exists(folder_ / "description.json", ignored);
  std::vector<fs::path> unneeded;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder_, ignored)) {
    const fs::path& path = entry.path();
    if (path.extension() == ".part" ||
        (done && (path.extension() == ".exposure" || path.filename() == "outcome.json"))) {
      unneeded.push_back(path);
    }
  }
  for (const fs::path& path : unneeded) fs::remove(path, ignored);
}

}  // namespace geond::daemon
