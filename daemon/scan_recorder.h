// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
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
  int views = 0;                   // asked for
  int views_taken = 0;             // safe on disk
  double first_angle = 0.0;        // rad
  std::string label;               // by the client
  std::string error;               // of a failed one
  std::vector<std::string> types;  // of a done one: of its parts
  std::chrono::system_clock::time_point
      ended{};              // when it ended; of one that runs or was cut short, when it last wrote
  std::uint64_t bytes = 0;  // of its folder
  bool pinned = false;      // kept whatever its age

  bool operator==(const ScanSummary&) const = default;
};

// What a scan's folder says of itself; one that was running when the program died is interrupted, one whose files
// contradict each other is failed and says so.
ScanSummary ReadSummary(const std::filesystem::path& folder, int id);

// Writes one scan's folder; lives on the thread that has it. What a call has written is on disk and synced when it
// returns. All calls throw FileError.
class ScanRecorder {
 public:
  explicit ScanRecorder(std::filesystem::path folder) : folder_(std::move(folder)) {}
  // What was asked for: with it the folder is a scan.
  void KeepPlan(int views, double first_angle, const std::string& label) const;
  void KeepView(int view, const Exposure& exposure) const;
  // The whole of a finished scan: recorded scan, cloud, mesh, description, picture if wanted. The exposures go.
  void Finish(const RecordedScan& scan, const ObjectModel& model, bool picture) const;
  // How its parts can be taken, as JSON; to be kept before Finish.
  void KeepGrasps(const std::string& grasps) const;
  // Why there is no description. Views taken stay, so that the scan can be resumed.
  void Abandon(ScanState state, const std::string& error) const;
  // Keeps the scan from being removed for its age or size, or no longer.
  void Pin(bool pinned) const;
  // The views that are safe, in order, up to the first that is missing or damaged.
  std::vector<Exposure> Views() const;
  // Removes what a crash left behind and nobody needs: half-written files, the exposures of a finished scan. Never
  // throws.
  void Tidy() const noexcept;
  const std::filesystem::path& folder() const { return folder_; }

 private:
  std::filesystem::path folder_;
};

}  // namespace geond::daemon
