// SPDX-License-Identifier: Apache-2.0
#include "daemon/scan_archive.h"

#include <zip.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/base/progress.h"
#include "core/range/scan_folder.h"
#include "daemon/durable_file.h"
#include "daemon/http_files.h"
#include "daemon/scan_recorder.h"

namespace geond::daemon {
namespace {

namespace fs = std::filesystem;

// Left as it is if it is not closed: an archive that is being made then never comes to be.
struct Discard {
  void operator()(zip_t* archive) const { zip_discard(archive); }
};
using Archive = std::unique_ptr<zip_t, Discard>;

Archive Open(const fs::path& path, int flags) {
  int code = 0;
  zip_t* archive = zip_open(path.c_str(), flags, &code);
  if (archive) return Archive(archive);
  zip_error_t error;
  zip_error_init_with_code(&error, code);
  const std::string cause = zip_error_strerror(&error);
  zip_error_fini(&error);
  throw FileError(path.string(), "open archive", cause, "It must be a zip that `geon export` made");
}

[[noreturn]] void Fail(const fs::path& path, const char* call, zip_t* archive) {
  throw FileError(path.string(), call, zip_strerror(archive), "Check free space and permissions");
}

bool Belongs(const fs::path& file) { return file.extension() != ".part" && file.filename() != "pinned"; }

// The name of a file in the archive without its one folder; throws if it leads anywhere else.
std::string PlainName(const fs::path& archive, const char* name) {
  const std::string_view whole = name ? name : "";
  const std::size_t slash = whole.find('/');
  const std::string_view file = slash == std::string_view::npos ? whole : whole.substr(slash + 1);
  if (!IsPlainPath(whole) || file.empty() || file.find('/') != std::string_view::npos || !Belongs(file)) {
    throw FileError(archive.string(), "unpack", "the name '" + std::string(whole) + "' is none of a scan's file");
  }
  return std::string(file);
}

void Unpack(const fs::path& path, zip_t* archive, zip_uint64_t index, std::uint64_t size, const fs::path& to) {
  const std::unique_ptr<zip_file_t, int (*)(zip_file_t*)> file(zip_fopen_index(archive, index, 0), zip_fclose);
  if (!file) Fail(path, "unpack", archive);
  std::ofstream out(to, std::ios::binary);
  std::vector<char> buffer(1 << 18);
  std::uint64_t done = 0;
  for (zip_int64_t n; (n = zip_fread(file.get(), buffer.data(), buffer.size())) != 0;) {
    if (n < 0)
      throw FileError(path.string(), "unpack", zip_file_strerror(file.get()),
                      "The archive is damaged: export it again");
    done += static_cast<std::uint64_t>(n);
    if (done > size) throw FileError(path.string(), "unpack", "a file is longer than the archive says");
    out.write(buffer.data(), n);
  }
  out.close();
  if (done != size) throw FileError(path.string(), "unpack", "a file is shorter than the archive says");
  if (!out) throw FileError(to.string(), "write", std::strerror(errno), "Make room on the disk");
  SyncFile(to);
}

// Whether the unpacked files are a scan, down to the sums of its images.
void CheckScanFolder(const fs::path& archive, const fs::path& folder) {
  const ScanSummary scan = ReadSummary(folder, 1);
  if (!fs::exists(folder / "journal.json")) {
    throw FileError(archive.string(), "unpack", "there is no journal.json in it",
                    "It must be a zip that `geon export` made");
  }
  if (scan.state == ScanState::kDone) ReadScan(folder);
  if (scan.state == ScanState::kFailed && !fs::exists(folder / "outcome.json")) {
    throw FileError(archive.string(), "unpack", scan.error);
  }
}

}  // namespace

void WriteScanArchive(const fs::path& folder, const fs::path& path, std::stop_token stop) {
  std::vector<fs::path> files;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    if (entry.is_regular_file() && Belongs(entry.path())) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  std::error_code error;
  fs::create_directories(path.parent_path(), error);
  fs::path unfinished = path;
  unfinished += ".part";
  Archive archive = Open(unfinished, ZIP_CREATE | ZIP_TRUNCATE);
  for (const fs::path& file : files) {
    zip_source_t* source = zip_source_file(archive.get(), file.c_str(), 0, -1);
    const std::string name = folder.filename().string() + "/" + file.filename().string();
    const zip_int64_t index = source ? zip_file_add(archive.get(), name.c_str(), source, ZIP_FL_ENC_UTF_8) : -1;
    if (index < 0) {
      zip_source_free(source);
      Fail(path, "pack", archive.get());
    }
    // Images are packed already; the rest at the least effort, which is nearly as small.
    const bool packed = file.extension() == ".png";
    zip_set_file_compression(archive.get(), static_cast<zip_uint64_t>(index), packed ? ZIP_CM_STORE : ZIP_CM_DEFLATE,
                             1);
  }
  zip_register_cancel_callback_with_state(
      archive.get(), [](zip_t*, void* token) { return static_cast<std::stop_token*>(token)->stop_requested() ? 1 : 0; },
      nullptr, &stop);
  if (zip_close(archive.get()) != 0) {
    ThrowIfStopped(stop);
    Fail(path, "write archive", archive.get());
  }
  archive.release();
  SyncFile(unfinished);
  fs::rename(unfinished, path, error);
  if (error) throw FileError(path.string(), "write archive", error.message());
}

void ReadScanArchive(const fs::path& path, const fs::path& folder, const ArchiveLimits& limits, std::stop_token stop) {
  const Archive archive = Open(path, ZIP_RDONLY);
  const zip_int64_t n = zip_get_num_entries(archive.get(), 0);
  if (n < 1 || n > limits.max_files) {
    throw FileError(path.string(), "unpack",
                    "it has " + std::to_string(n) + " files, not 1 to " + std::to_string(limits.max_files));
  }
  std::error_code error;
  fs::remove_all(folder, error);
  fs::create_directories(folder, error);
  if (error) throw FileError(folder.string(), "make folder", error.message(), "Check store.folder and its permissions");
  try {
    std::uint64_t total = 0;
    for (zip_uint64_t i = 0; i < static_cast<zip_uint64_t>(n); ++i) {
      ThrowIfStopped(stop);
      zip_stat_t entry;
      zip_stat_init(&entry);
      constexpr zip_uint64_t kNeeded = ZIP_STAT_NAME | ZIP_STAT_SIZE;
      if (zip_stat_index(archive.get(), i, 0, &entry) != 0 || (entry.valid & kNeeded) != kNeeded) {
        Fail(path, "unpack", archive.get());
      }
      if (std::string_view(entry.name).ends_with('/')) continue;
      total += entry.size;
      if (entry.size > limits.max_bytes || total > limits.max_bytes) {
        throw FileError(path.string(), "unpack",
                        "it unpacks to more than " + std::to_string(limits.max_bytes >> 20) + " MB");
      }
      Unpack(path, archive.get(), i, entry.size, folder / PlainName(path, entry.name));
    }
    CheckScanFolder(path, folder);
    SyncFolder(folder);
  } catch (...) {
    fs::remove_all(folder, error);
    throw;
  }
}

}  // namespace geond::daemon
