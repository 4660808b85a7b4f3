// SPDX-License-Identifier: Apache-2.0
#include "daemon/scan_store.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <map>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include "core/base/error.h"
#include "core/base/printed.h"
#include "daemon/durable_file.h"

namespace geond::daemon {
namespace {

namespace fs = std::filesystem;

constexpr char kDiscarded[] = ".deleted";

void MakeFolder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error)
    throw FileError(folder.string(), "make folder", error.message(), "Check store.folder, its disk and permissions");
}

// The number that a scan's folder is named for; 0: it is none.
int NumberOf(const std::string& name) {
  if (name.size() < 6 || name.size() > 9 || name.find_first_not_of("0123456789") != std::string::npos) return 0;
  return std::stoi(name);
}

}  // namespace

ScanStore::ScanStore(const fs::path& folder, StoreLimits limits) : folder_(folder), limits_(limits) {
  MakeFolder(folder_);
  Lock();
  try {
    index_ = std::make_unique<ScanIndex>(folder_ / "index.sqlite");
    Reconcile();
  } catch (...) {
    close(lock_);
    throw;
  }
}

ScanStore::~ScanStore() {
  index_.reset();
  close(lock_);
}

// Two programs would give the same number to two scans.
void ScanStore::Lock() {
  lock_ = open(folder_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (lock_ < 0)
    throw FileError(folder_.string(), "open", std::strerror(errno), "Check store.folder and its permissions");
  if (flock(lock_, LOCK_EX | LOCK_NB) == 0) return;
  close(lock_);
  throw FileError(folder_.string(), "lock", "another geond uses it", "Stop that one, or set another store.folder");
}

// Whether the folder contradicts what the index knows of a scan; asks for names only.
bool ScanStore::IsStale(const ScanSummary& known) const {
  const fs::path folder = Folder(known.id);
  return known.state == ScanState::kRunning ||
         (known.state == ScanState::kDone) != fs::exists(folder / "description.json") ||
         known.pinned != fs::exists(folder / "pinned");
}

void ScanStore::Reconcile() {
  std::error_code ignored;
  fs::remove_all(ImportFolder(), ignored);
  fs::remove_all(folder_ / "export", ignored);
  std::map<int, ScanSummary> known;
  for (ScanSummary& scan : index_->List({0, std::size_t{1} << 31, false})) known[scan.id] = std::move(scan);
  std::vector<fs::path> discarded;
  std::vector<int> stale;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder_)) {
    const std::string name = entry.path().filename().string();
    if (name.ends_with(kDiscarded)) discarded.push_back(entry.path());
    const int id = NumberOf(name);
    if (id == 0 || !entry.is_directory(ignored)) continue;
    greatest_ = std::max(greatest_, id);
    if (!fs::exists(entry.path() / "journal.json")) {
      // Begun and never acknowledged; what else may lie there is not ours to remove.
      fs::remove(entry.path() / "journal.json.part", ignored);
      fs::remove(entry.path(), ignored);
      continue;
    }
    const auto found = known.find(id);
    if (found == known.end() || IsStale(found->second)) stale.push_back(id);
    if (found != known.end()) known.erase(found);
  }
  for (const fs::path& path : discarded) fs::remove_all(path, ignored);
  if (!stale.empty() || !known.empty()) {
    index_->BeginChanges();
    for (const int id : stale) {
      ScanRecorder(Folder(id)).Tidy();
      index_->Put(ReadSummary(Folder(id), id));
    }
    for (const auto& [id, gone] : known) index_->Remove(id);
    index_->EndChanges();
  }
  newest_ = index_->Newest(false);
  newest_done_ = index_->Newest(true);
  greatest_ = std::max(greatest_, index_->GreatestEver());
}

fs::path ScanStore::Folder(int id) const { return folder_ / Printed("%06d", id); }

fs::path ScanStore::ExportFile(int id) const { return folder_ / "export" / (Folder(id).filename().string() + ".zip"); }

std::optional<ScanSummary> ScanStore::Find(int id) const {
  std::optional<ScanSummary> scan = index_->Find(id);
  // The index could not be told how it ended, on a full disk perhaps; its folder knows.
  if (scan && scan->state == ScanState::kRunning && id != running_) return ReadSummary(Folder(id), id);
  return scan;
}

void ScanStore::Put(const ScanSummary& scan) {
  index_->Put(scan);
  newest_ = std::max(newest_, scan.id);
  if (scan.state == ScanState::kDone) newest_done_ = std::max(newest_done_, scan.id);
}

int ScanStore::NextId() {
  greatest_ = std::max(greatest_, newest_) + 1;
  return greatest_;
}

std::uint64_t ScanStore::free_bytes() const {
  struct statvfs disk {};
  if (statvfs(folder_.c_str(), &disk) != 0) return 0;
  return static_cast<std::uint64_t>(disk.f_bavail) * disk.f_frsize;
}

void ScanStore::RefuseIfFull() const {
  if (free_bytes() >= limits_.min_free) return;
  throw FileError(folder_.string(), "begin scan",
                  "its disk has only " + std::to_string(free_bytes() >> 20) + " MB left",
                  "Delete or export old scans, or lower store.min_free_mb");
}

ScanRecorder ScanStore::Begin(int views, double first_angle, const std::string& label) {
  RefuseIfFull();
  const int id = NextId();
  ScanRecorder recorder(Folder(id));
  MakeFolder(recorder.folder());
  try {
    SyncFolder(folder_);
    recorder.KeepPlan(views, first_angle, label);
    ScanSummary scan = ReadSummary(recorder.folder(), id);
    scan.state = ScanState::kRunning;
    Put(scan);
  } catch (const FileError&) {
    std::error_code ignored;
    fs::remove_all(recorder.folder(), ignored);
    throw;
  }
  running_ = id;
  return recorder;
}

ScanRecorder ScanStore::Resume(int id) {
  RefuseIfFull();
  ScanRecorder recorder(Folder(id));
  recorder.Tidy();
  std::error_code ignored;
  fs::remove(recorder.folder() / "outcome.json", ignored);
  ScanSummary scan = ReadSummary(recorder.folder(), id);
  scan.state = ScanState::kRunning;
  Put(scan);
  running_ = id;
  return recorder;
}

void ScanStore::Refresh(int id) {
  if (running_ == id) running_ = 0;
  Put(ReadSummary(Folder(id), id));
}

void ScanStore::Pin(int id, bool pinned) {
  ScanRecorder(Folder(id)).Pin(pinned);
  ScanSummary scan = ReadSummary(Folder(id), id);
  if (id == running_) scan.state = ScanState::kRunning;
  Put(scan);
}

fs::path ScanStore::Discard(int id) {
  const fs::path folder = Folder(id);
  fs::path discarded = folder;
  discarded += kDiscarded;
  std::error_code error;
  fs::rename(folder, discarded, error);
  if (error && error != std::errc::no_such_file_or_directory) {
    throw FileError(folder.string(), "delete", error.message(), "Check the permissions");
  }
  SyncFolder(folder_);
  fs::remove(ExportFile(id), error);
  index_->Remove(id);
  if (id == newest_) newest_ = index_->Newest(false);
  if (id == newest_done_) newest_done_ = index_->Newest(true);
  return discarded;
}

void ScanStore::Delete(int id) {
  const fs::path discarded = Discard(id);
  std::error_code error;
  fs::remove_all(discarded, error);
  if (error) throw FileError(discarded.string(), "delete", error.message(), "Check the permissions");
}

int ScanStore::Adopt(const fs::path& folder) {
  const int id = NextId();
  std::error_code error;
  fs::rename(folder, Folder(id), error);
  if (error) throw FileError(folder.string(), "take in", error.message(), "Check the disk");
  SyncFolder(folder_);
  Put(ReadSummary(Folder(id), id));
  return id;
}

std::vector<int> ScanStore::Expired(std::chrono::system_clock::time_point now) const {
  std::vector<int> expired;
  if (limits_.max_age.count() == 0 && limits_.max_bytes == 0) return expired;
  std::uint64_t held = bytes();
  for (const ScanSummary& scan : index_->Removable()) {
    if (scan.id == newest_done_ || scan.id == running_) continue;
    const bool too_old = limits_.max_age.count() > 0 && now - scan.ended > limits_.max_age;
    const bool too_much = limits_.max_bytes > 0 && held > limits_.max_bytes;
    if (!too_old && !too_much) continue;
    expired.push_back(scan.id);
    held -= std::min(held, scan.bytes);
  }
  return expired;
}

std::string ScanStore::Description(int id) const { return ReadWhole(Folder(id) / "description.json"); }

std::string ScanStore::Grasps(int id) const { return ReadWhole(Folder(id) / "grasps.json"); }

}  // namespace geond::daemon
