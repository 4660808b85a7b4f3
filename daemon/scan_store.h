// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "core/object_model.h"
#include "core/range/scan_folder.h"

namespace geond::daemon {

enum class ScanState { kRunning, kInterrupted, kFailed, kCancelled, kDone };
std::string_view ScanStateName(ScanState state);  // "running", "interrupted", "failed", "cancelled", "done"

// What is known of a scan without opening its files.
struct ScanSummary {
  int id = 0;
  ScanState state = ScanState::kRunning;
  int views = 0;             // asked for
  int views_taken = 0;       // safe on disk
  double first_angle = 0.0;  // rad
  std::string label;         // by the client
  std::string error;         // of a failed one
  int n_parts = 0;           // of a done one
  std::vector<std::string> types;  // of its parts
  std::chrono::system_clock::time_point finished{};  // of a done one
};

// Writes one scan's folder; lives on the thread that has it. A view is on disk and synced when KeepView returns.
class ScanRecorder {
 public:
  explicit ScanRecorder(std::filesystem::path folder) : folder_(std::move(folder)) {}
  void KeepView(int view, const Exposure& exposure) const;
  // The whole of a finished scan: recorded scan, cloud, mesh, description, picture if wanted. The journal of views goes.
  void Finish(const RecordedScan& scan, const ObjectModel& model, bool picture) const;
  // How its parts can be taken, as JSON; to be kept before Finish.
  void KeepGrasps(const std::string& grasps) const;
  // Why there is no description. Views taken stay, so that the scan can be resumed.
  void Abandon(ScanState state, const std::string& error) const;
  // The views that are safe, in order, up to the first that is missing or damaged.
  std::vector<Exposure> Views() const;
  const std::filesystem::path& folder() const { return folder_; }

 private:
  std::filesystem::path folder_;
};

// The scans on disk: store.folder/000001 and so on. Lives on the I/O thread. All calls throw FileError.
class ScanStore {
 public:
  // Opens or makes the store and reads what is there; a scan that was running when the program died is interrupted.
  explicit ScanStore(const std::filesystem::path& folder);

  const std::map<int, ScanSummary>& scans() const { return scans_; }
  // A new scan, on disk as running.
  ScanRecorder Begin(int views, double first_angle, const std::string& label);
  // The same scan again, as running.
  ScanRecorder Resume(int id);
  // Reads again what its recorder wrote.
  void Refresh(int id);
  void Delete(int id);
  std::filesystem::path Folder(int id) const;
  // description.json of a done scan.
  std::string Description(int id) const;
  // grasps.json of a done scan.
  std::string Grasps(int id) const;

  // The one begun last; -1: none.
  int last_id() const { return last_id_; }

 private:
  std::filesystem::path folder_;
  std::map<int, ScanSummary> scans_;
  int last_id_ = -1;
};

}  // namespace geond::daemon
