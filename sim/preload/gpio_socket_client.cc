// SPDX-License-Identifier: Apache-2.0
// Preloaded into any program (libfake_gpio.so): it finds at /dev/gpiochip90 the fake chip whose socket GEOND_FAKE_GPIO
// names.
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <mutex>

#include "sim/fake_gpio_socket.h"
#include "sim/preload/gpio_system_calls.h"

namespace geond::sim {
namespace {

int Connect() {
  const char* path = std::getenv("GEOND_FAKE_GPIO");
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::strncpy(address.sun_path, path, sizeof address.sun_path - 1);
  const int fd = socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0);
  if (fd >= 0 && connect(fd, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0) return fd;
  if (fd >= 0) close(fd);
  return -1;
}

int Ioctl(int fd, unsigned long request, void* argument) {
  static std::mutex mutex;
  static int server = -1;
  const std::lock_guard lock(mutex);
  if (server < 0) server = Connect();
  GpioSocketMessage message;
  const std::size_t size = _IOC_SIZE(request);
  if (server < 0 || size > sizeof message.data) return -ENODEV;
  struct stat status {};
  message.request = request & 0xffffffff;
  message.inode = fstat(fd, &status) == 0 && S_ISSOCK(status.st_mode) ? status.st_ino : 0;
  std::memcpy(message.data, argument, size);
  if (send(server, &message, sizeof message, MSG_NOSIGNAL) != sizeof message) return -ENODEV;
  iovec whole{&message, sizeof message};
  alignas(cmsghdr) char control[CMSG_SPACE(sizeof(int))] = {};
  msghdr header{};
  header.msg_iov = &whole;
  header.msg_iovlen = 1;
  header.msg_control = control;
  header.msg_controllen = sizeof control;
  if (recvmsg(server, &header, MSG_CMSG_CLOEXEC) != sizeof message) return -ENODEV;
  if (const cmsghdr* rights = CMSG_FIRSTHDR(&header); rights != nullptr && message.fd_at != 0) {
    std::memcpy(message.data + message.fd_at, CMSG_DATA(rights), sizeof(int));
  }
  if (message.result >= 0) std::memcpy(argument, message.data, size);
  return message.result;
}

[[gnu::constructor]] void Mount() {
  if (std::getenv("GEOND_FAKE_GPIO") != nullptr) MountGpioChip(&Ioctl);
}

}  // namespace
}  // namespace geond::sim
