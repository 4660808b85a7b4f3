// SPDX-License-Identifier: Apache-2.0
// A scan's folder holds, in the order they come to be: journal.json (what was asked for), view_000.exposure and so on,
// then scan.json with its images, cloud.ply, mesh.ply, picture.png, and last description.json; then the exposures go.
// outcome.json says why there is no description.
#include "daemon/scan_store.h"

#include <algorithm>
#include <cstdio>
#include <utility>

#include <nlohmann/json.hpp>

#include "core/base/error.h"
#include "core/geometry/mesh_files.h"
#include "core/model_picture.h"
#include "daemon/durable_file.h"
#include "daemon/exposure_file.h"

namespace geond::daemon {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

std::string Numbered(const char* format, int number) {
  char text[32];
  std::snprintf(text, sizeof text, format, number);
  return text;
}

fs::path ViewFile(const fs::path& folder, int view) { return folder / Numbered("view_%03d.exposure", view); }

json ReadJson(const fs::path& path) {
  json value = json::parse(ReadWhole(path), nullptr, false);
  if (!value.is_object()) throw FileError(path.string(), "parse", "it is not a JSON object", "Delete the scan");
  return value;
}

void MakeFolder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw FileError(folder.string(), "make folder", error.message(), "Check store.folder and its permissions");
}

ScanState StateFromName(const std::string& name) {
  for (const ScanState state : {ScanState::kFailed, ScanState::kCancelled}) {
    if (ScanStateName(state) == name) return state;
  }
  return ScanState::kInterrupted;
}

// What a folder says of itself; a running scan reads as interrupted.
ScanSummary ReadSummary(const fs::path& folder, int id) {
  const json journal = ReadJson(folder / "journal.json");
  ScanSummary scan;
  scan.id = id;
  scan.views = journal.value("views", 0);
  scan.first_angle = journal.value("first_angle_rad", 0.0);
  scan.label = journal.value("label", "");
  if (fs::exists(folder / "description.json")) {
    scan.state = ScanState::kDone;
    scan.views_taken = scan.views;
    const json description = ReadJson(folder / "description.json");
    for (const json& part : description.at("parts")) scan.types.push_back(part.at("type"));
    scan.n_parts = static_cast<int>(scan.types.size());
    scan.finished = std::chrono::system_clock::time_point(std::chrono::seconds(ModifiedAt(folder / "description.json")));
    return scan;
  }
  scan.state = ScanState::kInterrupted;
  if (fs::exists(folder / "outcome.json")) {
    const json outcome = ReadJson(folder / "outcome.json");
    scan.state = StateFromName(outcome.value("state", ""));
    scan.error = outcome.value("error", "");
  }
  while (fs::exists(ViewFile(folder, scan.views_taken))) ++scan.views_taken;
  return scan;
}

}  // namespace

std::string_view ScanStateName(ScanState state) {
  switch (state) {
    case ScanState::kRunning: return "running";
    case ScanState::kInterrupted: return "interrupted";
    case ScanState::kFailed: return "failed";
    case ScanState::kCancelled: return "cancelled";
    case ScanState::kDone: return "done";
  }
  return "interrupted";
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
  WriteDurably(folder_ / "description.json", ToJson(model.description));
  std::error_code ignored;  // what stays behind is only unneeded
  fs::remove(folder_ / "outcome.json", ignored);
  for (int view = 0; fs::remove(ViewFile(folder_, view), ignored); ++view) {
  }
}

void ScanRecorder::KeepGrasps(const std::string& grasps) const { WriteDurably(folder_ / "grasps.json", grasps); }

void ScanRecorder::Abandon(ScanState state, const std::string& error) const {
  WriteDurably(folder_ / "outcome.json", json{{"state", ScanStateName(state)}, {"error", error}}.dump(2));
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

ScanStore::ScanStore(const fs::path& folder) : folder_(folder) {
  MakeFolder(folder_);
  for (const fs::directory_entry& entry : fs::directory_iterator(folder_)) {
    const std::string name = entry.path().filename().string();
    if (!entry.is_directory() || name.size() < 6 || name.find_first_not_of("0123456789") != std::string::npos) continue;
    const int id = std::stoi(name);
    last_id_ = std::max(last_id_, id);
    if (fs::exists(entry.path() / "journal.json")) Refresh(id);
  }
}

fs::path ScanStore::Folder(int id) const { return folder_ / Numbered("%06d", id); }

ScanRecorder ScanStore::Begin(int views, double first_angle, const std::string& label) {
  ScanSummary scan;
  scan.id = std::max(last_id_, 0) + 1;
  scan.views = views;
  scan.first_angle = first_angle;
  scan.label = label;
  const fs::path folder = Folder(scan.id);
  MakeFolder(folder);
  SyncFolder(folder_);
  WriteDurably(folder / "journal.json",
               json{{"views", views}, {"first_angle_rad", first_angle}, {"label", label}, {"software", GEOND_VERSION}}
                   .dump(2, ' ', false, json::error_handler_t::replace));
  last_id_ = scan.id;
  scans_[scan.id] = scan;
  return ScanRecorder(folder);
}

ScanRecorder ScanStore::Resume(int id) {
  scans_.at(id).state = ScanState::kRunning;
  scans_.at(id).error.clear();
  return ScanRecorder(Folder(id));
}

void ScanStore::Refresh(int id) {
  try {
    scans_[id] = ReadSummary(Folder(id), id);
  } catch (const std::exception& error) {
    ScanSummary broken;
    broken.id = id;
    broken.state = ScanState::kFailed;
    broken.error = error.what();
    scans_[id] = broken;
  }
}

void ScanStore::Delete(int id) {
  // Without its journal it is no scan any more, whatever a crash leaves of the rest.
  std::error_code error;
  fs::remove(Folder(id) / "journal.json", error);
  if (!error) SyncFolder(Folder(id));
  if (!error) fs::remove_all(Folder(id), error);
  if (error) throw FileError(Folder(id).string(), "delete", error.message(), "Check the permissions");
  scans_.erase(id);
}

std::string ScanStore::Description(int id) const { return ReadWhole(Folder(id) / "description.json"); }

std::string ScanStore::Grasps(int id) const { return ReadWhole(Folder(id) / "grasps.json"); }

}  // namespace geond::daemon
