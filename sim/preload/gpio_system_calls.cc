// SPDX-License-Identifier: Apache-2.0
// This program's own open, access, stat, lstat and ioctl, which shared libraries find before the C library's: calls for
// the mounted GPIO chip are answered here, all others go on to the next library.
#include "sim/preload/gpio_system_calls.h"

#include <dlfcn.h>
#include <fcntl.h>
#include <linux/gpio.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdarg>
#include <cstring>
#include <string_view>

namespace geond::sim {
namespace {

constexpr std::string_view kNumberFile = "/sys/bus/gpio/devices/gpiochip90/dev";
constexpr unsigned kMajor = 254, kMinor = 90;
std::atomic<GpioIoctl> mounted{nullptr};

bool IsChip(const char* path) { return mounted.load() != nullptr && std::string_view(path) == kGpioChipPath; }
bool IsNumberFile(const char* path) { return mounted.load() != nullptr && path == kNumberFile; }

int OpenNumberFile() {
  constexpr std::string_view kText = "254:90\n";
  const int fd = memfd_create("gpiochip90", MFD_CLOEXEC);
  if (fd >= 0 && (write(fd, kText.data(), kText.size()) < 0 || lseek(fd, 0, SEEK_SET) != 0)) {
    close(fd);
    return -1;
  }
  return fd;
}

// What `name` would be without this file.
template <typename Function>
Function* Next(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}

int Status(const char* name, const char* path, struct stat* status) {
  if (!IsChip(path)) return Next<int(const char*, struct stat*)>(name)(path, status);
  std::memset(status, 0, sizeof *status);
  status->st_mode = S_IFCHR | 0600;
  status->st_rdev = makedev(kMajor, kMinor);
  return 0;
}

}  // namespace

void MountGpioChip(GpioIoctl answer) { mounted = answer; }

}  // namespace geond::sim

extern "C" {

int open(const char* path, int flags, ...) {
  va_list arguments;
  va_start(arguments, flags);
  const mode_t mode = (flags & (O_CREAT | O_TMPFILE)) != 0 ? va_arg(arguments, mode_t) : 0;
  va_end(arguments);
  if (geond::sim::IsNumberFile(path)) return geond::sim::OpenNumberFile();
  if (geond::sim::IsChip(path)) path = "/dev/null";
  static auto* const next = geond::sim::Next<int(const char*, int, ...)>("open");
  return next(path, flags, mode);
}

int access(const char* path, int mode) noexcept {
  if (geond::sim::IsNumberFile(path) || geond::sim::IsChip(path)) return 0;
  static auto* const next = geond::sim::Next<int(const char*, int)>("access");
  return next(path, mode);
}

int lstat(const char* path, struct stat* status) noexcept { return geond::sim::Status("lstat", path, status); }

int stat(const char* path, struct stat* status) noexcept { return geond::sim::Status("stat", path, status); }

int ioctl(int fd, unsigned long request, ...) noexcept {
  va_list arguments;
  va_start(arguments, request);
  void* argument = va_arg(arguments, void*);
  va_end(arguments);
  const geond::sim::GpioIoctl answer = geond::sim::mounted.load();
  static auto* const next = geond::sim::Next<int(int, unsigned long, ...)>("ioctl");
  if (answer == nullptr || ((request >> 8) & 0xff) != 0xB4) return next(fd, request, argument);
  const int result = answer(fd, request, argument);
  if (result >= 0) return result;
  errno = -result;
  return -1;
}

}  // extern "C"
