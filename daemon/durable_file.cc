// SPDX-License-Identifier: Apache-2.0
#include "daemon/durable_file.h"

#include <cerrno>
#include <cstring>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include "core/base/error.h"

namespace geond::daemon {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void Fail(const fs::path& path, const char* call, int error) {
  const char* remedy = error == ENOSPC || error == EDQUOT ? "Make room on the disk: delete or export old scans"
                       : error == EROFS                   ? "The disk is read-only: check it and mount it again"
                       : error == EACCES || error == EPERM ? "Check the folder's owner and permissions"
                                                           : "Check the disk";
  throw FileError(path.string(), call, std::strerror(error), remedy);
}

// An open file that is closed whatever happens.
class Descriptor {
 public:
  Descriptor(const fs::path& path, int flags, mode_t mode = 0) : fd_(open(path.c_str(), flags | O_CLOEXEC, mode)) {
    if (fd_ < 0) Fail(path, "open", errno);
  }
  ~Descriptor() {
    if (fd_ >= 0) close(fd_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int get() const { return fd_; }

 private:
  int fd_;
};

}  // namespace

void WriteDurably(const fs::path& path, std::string_view bytes) {
  fs::path beside = path;
  beside += ".part";
  try {
    const Descriptor file(beside, O_WRONLY | O_CREAT | O_TRUNC, 0640);
    for (std::size_t done = 0; done < bytes.size();) {
      const ssize_t n = write(file.get(), bytes.data() + done, bytes.size() - done);
      if (n < 0 && errno == EINTR) continue;
      if (n < 0) Fail(path, "write", errno);
      done += static_cast<std::size_t>(n);
    }
    if (fsync(file.get()) != 0) Fail(path, "sync", errno);
    if (rename(beside.c_str(), path.c_str()) != 0) Fail(path, "rename", errno);
  } catch (const FileError&) {
    unlink(beside.c_str());
    throw;
  }
  SyncFolder(path.parent_path());
}

void SyncFile(const fs::path& path) {
  const Descriptor file(path, O_RDONLY);
  if (fsync(file.get()) != 0) Fail(path, "sync", errno);
}

void SyncFolder(const fs::path& folder) {
  const Descriptor directory(folder.empty() ? fs::path(".") : folder, O_RDONLY | O_DIRECTORY);
  if (fsync(directory.get()) != 0 && errno != EINVAL) Fail(folder, "sync", errno);
}

std::int64_t ModifiedAt(const fs::path& path) {
  struct stat status {};
  if (stat(path.c_str(), &status) != 0) Fail(path, "look at", errno);
  return status.st_mtime;
}

std::string ReadWhole(const fs::path& path, std::size_t max_bytes) {
  const Descriptor file(path, O_RDONLY);
  struct stat status {};
  if (fstat(file.get(), &status) != 0) Fail(path, "read", errno);
  if (static_cast<std::size_t>(status.st_size) > max_bytes) {
    throw FileError(path.string(), "read", "it has more than " + std::to_string(max_bytes) + " bytes");
  }
  std::string bytes;
  char buffer[1 << 16];
  while (true) {
    const ssize_t n = read(file.get(), buffer, sizeof buffer);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) Fail(path, "read", errno);
    if (n == 0) return bytes;
    bytes.append(buffer, static_cast<std::size_t>(n));
    if (bytes.size() > max_bytes) throw FileError(path.string(), "read", "it grows while it is read");
  }
}

}  // namespace geond::daemon
