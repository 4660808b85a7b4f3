// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "daemon/scan_index.h"
#include "daemon/scan_recorder.h"

namespace geond::daemon {

// How much is kept; 0: no limit.
struct StoreLimits {
  std::chrono::hours max_age{0};  // since a scan ended
  std::uint64_t max_bytes = 0;    // of all scans together
  std::uint64_t min_free = 0;     // bytes of the disk below which no scan begins
};

// The scans on disk: store.folder/000001 and so on, and an index of them. Lives on the I/O thread. All calls throw
// FileError.
class ScanStore {
 public:
  // Opens or makes the store, for this program alone. The folders are right where the index says otherwise; a scan that
  // was running when the program died is interrupted.
  explicit ScanStore(const std::filesystem::path& folder, StoreLimits limits = {});
  ~ScanStore();
  ScanStore(const ScanStore&) = delete;
  ScanStore& operator=(const ScanStore&) = delete;

  std::optional<ScanSummary> Find(int id) const;
  std::vector<ScanSummary> List(const ScanFilter& filter = {}) const { return index_->List(filter); }
  // The number of the newest scan, of the newest with a description; 0: none.
  int newest() const { return newest_; }
  int newest_done() const { return newest_done_; }
  int count() const { return index_->count(); }
  std::uint64_t bytes() const { return index_->bytes(); }
  // Bytes that can still be written to its disk.
  std::uint64_t free_bytes() const;
  const StoreLimits& limits() const { return limits_; }
  void SetLimits(const StoreLimits& limits) { limits_ = limits; }

  // A new scan, on disk as running. Throws FileError also if the disk is nearly full.
  ScanRecorder Begin(int views, double first_angle, const std::string& label);
  // The same scan again, as running.
  ScanRecorder Resume(int id);
  // Reads again what its recorder wrote.
  void Refresh(int id);
  void Pin(int id, bool pinned);
  // Takes a scan out of the store at once. Returns the folder that is left of it, to be removed when there is time.
  std::filesystem::path Discard(int id);
  void Delete(int id);
  // Takes a folder that holds a whole scan (ReadScanArchive makes one in ImportFolder) into the store as a new one. Its
  // number.
  int Adopt(const std::filesystem::path& folder);

  // The scans that the limits want gone at that time, oldest first: never pinned ones nor the newest with a
  // description.
  std::vector<int> Expired(std::chrono::system_clock::time_point now) const;

  std::filesystem::path Folder(int id) const;
  // Places beside the scans for archives to leave by, and for what is being taken in; emptied when the store is opened.
  std::filesystem::path ExportFile(int id) const;
  std::filesystem::path ImportFolder() const { return folder_ / "import"; }
  // description.json and grasps.json of a done scan.
  std::string Description(int id) const;
  std::string Grasps(int id) const;

 private:
  void Lock();
  void Reconcile();
  bool IsStale(const ScanSummary& known) const;
  void Put(const ScanSummary& scan);
  int NextId();
  void RefuseIfFull() const;

  const std::filesystem::path folder_;
  StoreLimits limits_;
  int lock_ = -1;  // descriptor of the folder, locked
  std::unique_ptr<ScanIndex> index_;
  int newest_ = 0, newest_done_ = 0, greatest_ = 0;
  int running_ = 0;  // the scan that a recorder of this program writes
};

}  // namespace geond::daemon
