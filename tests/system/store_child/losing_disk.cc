// SPDX-License-Identifier: Apache-2.0
#include "tests/system/store_child/losing_disk.h"

#include <csignal>
#include <cstdarg>
#include <cstdio>
#include <cstring>
#include <list>
#include <map>
#include <mutex>
#include <set>
#include <utility>
#include <vector>

#include <dlfcn.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <sys/uio.h>
#include <unistd.h>

namespace losing_disk {
namespace {

template <typename Call>
Call Real(const char* name) {
  return reinterpret_cast<Call>(dlsym(RTLD_NEXT, name));
}
int RealOpen(const char* path, int flags, mode_t mode = 0) {
  static const auto real = Real<int (*)(const char*, int, ...)>("open");
  return real(path, flags, mode);
}
int RealRename(const char* from, const char* to) {
  static const auto real = Real<int (*)(const char*, const char*)>("rename");
  return real(from, to);
}
int RealUnlink(const char* path) {
  static const auto real = Real<int (*)(const char*)>("unlink");
  return real(path);
}

using Inode = std::pair<dev_t, ino_t>;

// A file that was opened to be written.
struct File {
  int fd = -1;       // our own, to read and mend it by whatever it is called
  std::string safe;  // its bytes at the last sync
};
// A change of a name that its folder was not synced after.
struct Change {
  enum class Kind { kCreate, kRename, kUnlink, kMakeFolder } kind;
  Inode folder;
  std::string name, before;  // of a rename: what it was called
  std::string kept;          // another name of the file that lost its own; empty: none did
};

struct Disk {
  std::recursive_mutex mutex;
  std::string folder, backup;
  int crash_at = 0, calls = 0, kept = 0;
  Loss loss = Loss::kNothing;
  std::uint64_t random = 1;
  std::map<Inode, File> files;
  std::list<Change> changes;
};
Disk& TheDisk() {
  static Disk* const disk = new Disk;  // used until the very end of the program
  return *disk;
}

std::uint64_t Random(Disk& disk) {  // xorshift64*
  disk.random ^= disk.random >> 12;
  disk.random ^= disk.random << 25;
  disk.random ^= disk.random >> 27;
  return disk.random * 0x2545f4914f6cdd1du;
}

std::string Absolute(int folder_fd, const char* path) {
  if (path[0] == '/') return path;
  char base[4096];
  ssize_t n = -1;
  if (folder_fd == AT_FDCWD) {
    if (getcwd(base, sizeof base)) n = static_cast<ssize_t>(std::strlen(base));
  } else {
    n = readlink(("/proc/self/fd/" + std::to_string(folder_fd)).c_str(), base, sizeof base);
  }
  return n < 0 ? path : std::string(base, static_cast<std::size_t>(n)) + "/" + path;
}

bool IsOurs(const Disk& disk, const std::string& path) {
  return !disk.folder.empty() && path.size() > disk.folder.size() &&
         path.compare(0, disk.folder.size(), disk.folder) == 0 && path[disk.folder.size()] == '/';
}

std::string FolderOf(const std::string& path) { return path.substr(0, path.rfind('/')); }

Inode InodeOf(const std::string& path) {
  struct stat status {};
  return stat(path.c_str(), &status) == 0 ? Inode{status.st_dev, status.st_ino} : Inode{};
}
Inode InodeOf(int fd) {
  struct stat status {};
  return fstat(fd, &status) == 0 ? Inode{status.st_dev, status.st_ino} : Inode{};
}

std::string Bytes(int fd) {
  std::string bytes;
  char buffer[1 << 16];
  for (off_t at = 0;;) {
    const ssize_t n = pread(fd, buffer, sizeof buffer, at);
    if (n <= 0) return bytes;
    bytes.append(buffer, static_cast<std::size_t>(n));
    at += n;
  }
}

void Rewrite(int fd, const std::string& bytes) {
  static const auto real_write = Real<ssize_t (*)(int, const void*, std::size_t, off_t)>("pwrite");
  static const auto real_truncate = Real<int (*)(int, off_t)>("ftruncate");
  real_truncate(fd, 0);
  for (std::size_t done = 0; done < bytes.size();) {
    const ssize_t n = real_write(fd, bytes.data() + done, bytes.size() - done, static_cast<off_t>(done));
    if (n <= 0) return;
    done += static_cast<std::size_t>(n);
  }
}

// Some blocks of the old and some of the new, as long as either or in between.
std::string Torn(Disk& disk, const std::string& safe, const std::string& now) {
  const std::size_t shorter = std::min(safe.size(), now.size()), longer = std::max(safe.size(), now.size());
  std::string torn(shorter + Random(disk) % (longer - shorter + 1), '\0');
  constexpr std::size_t kBlock = 512;
  for (std::size_t at = 0; at < torn.size(); at += kBlock) {
    const std::string& from = Random(disk) % 2 ? safe : now;
    for (std::size_t i = at; i < std::min(at + kBlock, torn.size()); ++i) torn[i] = i < from.size() ? from[i] : '\0';
  }
  return torn;
}

void Undo(const Change& change) {
  switch (change.kind) {
    case Change::Kind::kCreate:
      RealUnlink(change.name.c_str());
      break;
    case Change::Kind::kRename:
      RealRename(change.name.c_str(), change.before.c_str());
      break;
    case Change::Kind::kMakeFolder:
      RealRename(change.name.c_str(), (TheDisk().backup + "/folder" + std::to_string(++TheDisk().kept)).c_str());
      break;
    case Change::Kind::kUnlink:
      break;
  }
  if (!change.kept.empty()) RealRename(change.kept.c_str(), change.name.c_str());
}

[[noreturn]] void LosePower(Disk& disk) {
  if (disk.loss != Loss::kNothing) {
    for (auto& [inode, file] : disk.files) {
      const std::string now = Bytes(file.fd);
      if (now == file.safe) continue;
      Rewrite(file.fd, disk.loss == Loss::kAll ? file.safe : Torn(disk, file.safe, now));
    }
    // Of each folder's changes the first so many survive.
    std::map<Inode, std::size_t> count, survive;
    for (const Change& change : disk.changes) ++count[change.folder];
    for (const auto& [folder, n] : count) survive[folder] = disk.loss == Loss::kAll ? 0 : Random(disk) % (n + 1);
    for (auto change = disk.changes.rbegin(); change != disk.changes.rend(); ++change) {
      if (count[change->folder]-- > survive[change->folder]) Undo(*change);
    }
  }
  kill(getpid(), SIGKILL);
  while (true) pause();
}

// A call that changes the disk is about to be made.
void Count(Disk& disk) {
  if (++disk.calls == disk.crash_at) LosePower(disk);
}

void Remember(Disk& disk, Change change) {
  change.folder = InodeOf(FolderOf(change.name));
  disk.changes.push_back(std::move(change));
}

// Another name for a file that is about to lose its own.
std::string Keep(Disk& disk, const std::string& path) {
  const std::string kept = disk.backup + "/file" + std::to_string(++disk.kept);
  return link(path.c_str(), kept.c_str()) == 0 ? kept : "";
}

// Around an open for writing: what was there before, and what is to be watched from now on.
template <typename Open>
auto Opened(const std::string& path, bool writes, bool truncates, const Open& open, auto failed) {
  Disk& disk = TheDisk();
  const std::lock_guard lock(disk.mutex);
  if (!writes || !IsOurs(disk, path)) return open();
  const bool existed = access(path.c_str(), F_OK) == 0;
  std::string safe;
  if (existed) {
    const int fd = RealOpen(path.c_str(), O_RDONLY);
    if (fd >= 0) {
      if (!disk.files.contains(InodeOf(fd))) safe = Bytes(fd);
      close(fd);
    }
  }
  if (!existed || truncates) Count(disk);
  const auto result = open();
  if (result == failed) return result;
  const Inode inode = InodeOf(path);
  if (!disk.files.contains(inode)) disk.files[inode] = {RealOpen(path.c_str(), O_RDWR | O_CLOEXEC), std::move(safe)};
  if (!existed) Remember(disk, {Change::Kind::kCreate, {}, path, {}, {}});
  return result;
}

template <typename Write>
auto Wrote(int fd, const Write& write) {
  Disk& disk = TheDisk();
  const std::lock_guard lock(disk.mutex);
  if (!disk.folder.empty() && disk.files.contains(InodeOf(fd))) Count(disk);
  return write();
}

template <typename Sync>
int Synced(int fd, const Sync& sync) {
  Disk& disk = TheDisk();
  const std::lock_guard lock(disk.mutex);
  if (disk.folder.empty()) return sync();
  const Inode inode = InodeOf(fd);
  struct stat status {};
  const bool folder = fstat(fd, &status) == 0 && S_ISDIR(status.st_mode);
  const auto file = disk.files.find(inode);
  if (folder || file != disk.files.end()) Count(disk);
  const int result = sync();
  if (result != 0) return result;
  if (file != disk.files.end()) file->second.safe = Bytes(file->second.fd);
  if (folder) disk.changes.remove_if([&](const Change& change) { return change.folder == inode; });
  return result;
}

int Renamed(const std::string& from, const std::string& to, const auto& rename) {
  Disk& disk = TheDisk();
  const std::lock_guard lock(disk.mutex);
  if (!IsOurs(disk, to)) return rename();
  Count(disk);
  const std::string kept = Keep(disk, to);
  const int result = rename();
  if (result == 0) Remember(disk, {Change::Kind::kRename, {}, to, from, kept});
  return result;
}

int Removed(const std::string& path, const auto& remove) {
  Disk& disk = TheDisk();
  const std::lock_guard lock(disk.mutex);
  if (!IsOurs(disk, path) || access(path.c_str(), F_OK) != 0) return remove();
  Count(disk);
  const std::string kept = Keep(disk, path);  // none for a folder: it is empty, and its loss is no loss
  const int result = remove();
  if (result == 0 && !kept.empty()) Remember(disk, {Change::Kind::kUnlink, {}, path, {}, kept});
  return result;
}

}  // namespace

void Arm(const std::string& folder, int crash_at, Loss loss, std::uint64_t seed) {
  Disk& disk = TheDisk();
  const std::lock_guard lock(disk.mutex);
  disk.backup = folder + ".lost";
  mkdir(disk.backup.c_str(), 0700);
  disk.crash_at = crash_at;
  disk.loss = loss;
  disk.random = seed * 0x9e3779b97f4a7c15u + 1;
  disk.folder = folder;
}

int calls() { return TheDisk().calls; }

}  // namespace losing_disk

// --- the calls themselves
extern "C" {

using losing_disk::Absolute;
using losing_disk::Real;

#define GEOND_OPEN(NAME)                                                                   \
  int NAME(const char* path, int flags, ...) {                                             \
    va_list list;                                                                          \
    va_start(list, flags);                                                                 \
    const mode_t mode = (flags & (O_CREAT | O_TMPFILE)) ? va_arg(list, mode_t) : 0;        \
    va_end(list);                                                                          \
    static const auto real = Real<int (*)(const char*, int, ...)>(#NAME);                  \
    return losing_disk::Opened(                                                            \
        Absolute(AT_FDCWD, path), (flags & O_ACCMODE) != O_RDONLY, (flags & O_TRUNC) != 0, \
        [&] { return real(path, flags, mode); }, -1);                                      \
  }
GEOND_OPEN(open)
GEOND_OPEN(open64)

#define GEOND_FOPEN(NAME)                                                               \
  FILE* NAME(const char* path, const char* mode) {                                      \
    static const auto real = Real<FILE* (*)(const char*, const char*)>(#NAME);          \
    return losing_disk::Opened(                                                         \
        Absolute(AT_FDCWD, path), std::strpbrk(mode, "wa+") != nullptr, mode[0] == 'w', \
        [&] { return real(path, mode); }, static_cast<FILE*>(nullptr));                 \
  }
GEOND_FOPEN(fopen)
GEOND_FOPEN(fopen64)

ssize_t write(int fd, const void* bytes, std::size_t n) {
  static const auto real = Real<ssize_t (*)(int, const void*, std::size_t)>("write");
  return losing_disk::Wrote(fd, [&] { return real(fd, bytes, n); });
}
ssize_t writev(int fd, const iovec* parts, int n) {
  static const auto real = Real<ssize_t (*)(int, const iovec*, int)>("writev");
  return losing_disk::Wrote(fd, [&] { return real(fd, parts, n); });
}
ssize_t pwrite(int fd, const void* bytes, std::size_t n, off_t at) {
  static const auto real = Real<ssize_t (*)(int, const void*, std::size_t, off_t)>("pwrite");
  return losing_disk::Wrote(fd, [&] { return real(fd, bytes, n, at); });
}
ssize_t pwrite64(int fd, const void* bytes, std::size_t n, off64_t at) {
  static const auto real = Real<ssize_t (*)(int, const void*, std::size_t, off64_t)>("pwrite64");
  return losing_disk::Wrote(fd, [&] { return real(fd, bytes, n, at); });
}
int ftruncate(int fd, off_t size) noexcept {
  static const auto real = Real<int (*)(int, off_t)>("ftruncate");
  return losing_disk::Wrote(fd, [&] { return real(fd, size); });
}
int ftruncate64(int fd, off64_t size) noexcept {
  static const auto real = Real<int (*)(int, off64_t)>("ftruncate64");
  return losing_disk::Wrote(fd, [&] { return real(fd, size); });
}
int fsync(int fd) {
  static const auto real = Real<int (*)(int)>("fsync");
  return losing_disk::Synced(fd, [&] { return real(fd); });
}
int fdatasync(int fd) {
  static const auto real = Real<int (*)(int)>("fdatasync");
  return losing_disk::Synced(fd, [&] { return real(fd); });
}
int rename(const char* from, const char* to) noexcept {
  return losing_disk::Renamed(Absolute(AT_FDCWD, from), Absolute(AT_FDCWD, to),
                              [&] { return losing_disk::RealRename(from, to); });
}
int unlink(const char* path) noexcept {
  return losing_disk::Removed(Absolute(AT_FDCWD, path), [&] { return losing_disk::RealUnlink(path); });
}
int remove(const char* path) noexcept {
  static const auto real = Real<int (*)(const char*)>("remove");
  return losing_disk::Removed(Absolute(AT_FDCWD, path), [&] { return real(path); });
}
int unlinkat(int folder, const char* path, int flags) noexcept {
  static const auto real = Real<int (*)(int, const char*, int)>("unlinkat");
  return losing_disk::Removed(Absolute(folder, path), [&] { return real(folder, path, flags); });
}
int mkdir(const char* path, mode_t mode) noexcept {
  static const auto real = Real<int (*)(const char*, mode_t)>("mkdir");
  losing_disk::Disk& disk = losing_disk::TheDisk();
  const std::lock_guard lock(disk.mutex);
  const std::string absolute = Absolute(AT_FDCWD, path);
  if (!losing_disk::IsOurs(disk, absolute) || access(path, F_OK) == 0) return real(path, mode);
  losing_disk::Count(disk);
  const int result = real(path, mode);
  if (result == 0) losing_disk::Remember(disk, {losing_disk::Change::Kind::kMakeFolder, {}, absolute, {}, {}});
  return result;
}

}  // extern "C"
