// SPDX-License-Identifier: Apache-2.0
#include "sim/fake_gpio_socket.h"

#include <linux/gpio.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstring>
#include <vector>

#include "core/base/error.h"

namespace geond::sim {
namespace {

constexpr int kLookUpMs = 20;  // how soon the end is seen

// Where an ioctl that makes a descriptor puts it.
std::uint32_t DescriptorPlace(std::uint64_t request) {
  if (request == GPIO_GET_LINEHANDLE_IOCTL) return offsetof(gpiohandle_request, fd);
  if (request == GPIO_GET_LINEEVENT_IOCTL) return offsetof(gpioevent_request, fd);
  return 0;
}

}  // namespace

FakeGpioSocket::FakeGpioSocket(FakeGpioChip& chip, const std::string& path) : chip_(chip), path_(path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.size() >= sizeof address.sun_path) throw FileError(path, "listen", "the path is too long");
  std::copy(path.begin(), path.end(), address.sun_path);
  unlink(path.c_str());  // one that a dead program left
  listener_ = socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0);
  if (listener_ < 0 || bind(listener_, reinterpret_cast<sockaddr*>(&address), sizeof address) != 0 ||
      listen(listener_, 16) != 0) {
    const int error = errno;
    if (listener_ >= 0) close(listener_);
    throw FileError(path, "listen", std::strerror(error));
  }
  thread_ = std::jthread([this](std::stop_token stop) { Serve(stop); });
}

FakeGpioSocket::~FakeGpioSocket() {
  thread_.request_stop();
  thread_.join();
  close(listener_);
  unlink(path_.c_str());
}

void FakeGpioSocket::Serve(std::stop_token stop) {
  std::vector<pollfd> watched = {{listener_, POLLIN, 0}};
  while (!stop.stop_requested()) {
    if (poll(watched.data(), watched.size(), kLookUpMs) <= 0) continue;
    const bool caller = watched.front().revents != 0;
    for (std::size_t i = watched.size(); i-- > 1;) {
      if (watched[i].revents == 0 || Answer(watched[i].fd)) continue;
      close(watched[i].fd);
      watched.erase(watched.begin() + static_cast<std::ptrdiff_t>(i));
    }
    if (!caller) continue;
    if (const int client = accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC); client >= 0)
      watched.push_back({client, POLLIN, 0});
  }
  for (std::size_t i = 1; i < watched.size(); ++i) close(watched[i].fd);
}

bool FakeGpioSocket::Answer(int client) {
  GpioSocketMessage message;
  if (recv(client, &message, sizeof message, 0) != sizeof message) return false;
  message.result = chip_.IoctlOn(message.inode, message.request, message.data);
  message.fd_at = message.result < 0 ? 0 : DescriptorPlace(message.request);
  iovec whole{&message, sizeof message};
  msghdr header{};
  header.msg_iov = &whole;
  header.msg_iovlen = 1;
  alignas(cmsghdr) char control[CMSG_SPACE(sizeof(int))] = {};
  int fd = -1;
  if (message.fd_at != 0) {
    std::memcpy(&fd, message.data + message.fd_at, sizeof fd);
    header.msg_control = control;
    header.msg_controllen = sizeof control;
    cmsghdr* rights = CMSG_FIRSTHDR(&header);
    rights->cmsg_level = SOL_SOCKET;
    rights->cmsg_type = SCM_RIGHTS;
    rights->cmsg_len = CMSG_LEN(sizeof fd);
    std::memcpy(CMSG_DATA(rights), &fd, sizeof fd);
  }
  const bool sent = sendmsg(client, &header, MSG_NOSIGNAL) == sizeof message;
  if (fd >= 0) close(fd);
  return sent;
}

}  // namespace geond::sim
