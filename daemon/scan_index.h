// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "daemon/scan_recorder.h"

struct sqlite3;

namespace geond::daemon {

// Which scans a list is about.
struct ScanFilter {
  int before = 0;           // only scans with a smaller number; 0: all
  std::size_t limit = 100;  // at most so many
  bool done = false;        // only those with a description
};

// What the folders of all scans say, in one SQLite file (write-ahead log, synced at every change), so that thousands of
// scans need not be read to list them. It holds nothing that the folders do not: a broken or lost one is made anew.
// Lives on one thread; calls throw FileError.
class ScanIndex {
 public:
  // Opens or makes the file; a broken one is replaced by an empty one. Where the disk cannot be written the index is
  // kept in memory.
  explicit ScanIndex(const std::filesystem::path& path);
  ~ScanIndex();
  ScanIndex(const ScanIndex&) = delete;
  ScanIndex& operator=(const ScanIndex&) = delete;

  void Put(const ScanSummary& scan);
  void Remove(int id);
  // All or none of what is put until EndChanges comes to be.
  void BeginChanges();
  void EndChanges();

  std::optional<ScanSummary> Find(int id) const;
  // Newest first.
  std::vector<ScanSummary> List(const ScanFilter& filter) const;
  // Those that are not pinned and have ended, oldest first, with number, time and bytes alone.
  std::vector<ScanSummary> Removable() const;
  // The number of the newest scan, of the newest with a description; 0: none.
  int Newest(bool done) const;
  // The greatest number that any scan had, those deleted too; 0: none.
  int GreatestEver() const;
  int count() const;
  std::uint64_t bytes() const;

  // Whether it is on disk.
  bool durable() const { return durable_; }

 private:
  bool Open(const std::string& path);
  void Close();
  std::int64_t Number(const char* question) const;

  std::string path_;
  sqlite3* database_ = nullptr;
  bool durable_ = true;
};

}  // namespace geond::daemon
