// SPDX-License-Identifier: Apache-2.0
#include "sim/fake_gpio_chip.h"

#include <linux/gpio.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <ctime>
#include <thread>
#include <utility>

namespace geond::sim {
namespace {

std::uint64_t InodeOf(int fd) {
  struct stat status{};
  return fstat(fd, &status) == 0 && S_ISSOCK(status.st_mode) ? status.st_ino : 0;
}

std::uint64_t MonotonicNanoseconds() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return static_cast<std::uint64_t>(now.tv_sec) * 1'000'000'000 + static_cast<std::uint64_t>(now.tv_nsec);
}

template <std::size_t Size>
void CopyName(const std::string& name, char (&to)[Size]) {
  const std::size_t length = std::min(name.size(), Size - 1);
  std::memcpy(to, name.data(), length);
  to[length] = '\0';
}

}  // namespace

FakeGpioChip::FakeGpioChip(unsigned lines, std::string label) : label_(std::move(label)), lines_(lines) {}

FakeGpioChip::~FakeGpioChip() {
  for (const auto& [inode, handle] : handles_) close(handle.fd);
}

void FakeGpioChip::SetLevel(unsigned number, bool high) {
  Line& line = lines_[number];
  if (line.high == high) return;
  line.high = high;
  if (high) ++line.rises;
  for (const auto& [inode, handle] : handles_) {
    if (handle.output || handle.edges == 0 || handle.lines.front() != number) continue;
    const unsigned edge = high != handle.active_low ? GPIOEVENT_EVENT_RISING_EDGE : GPIOEVENT_EVENT_FALLING_EDGE;
    const unsigned wanted =
        edge == GPIOEVENT_EVENT_RISING_EDGE ? GPIOEVENT_REQUEST_RISING_EDGE : GPIOEVENT_REQUEST_FALLING_EDGE;
    if ((handle.edges & wanted) == 0) continue;
    gpioevent_data event{};
    event.timestamp = MonotonicNanoseconds();
    event.id = edge;
    // As in the kernel, an event that nobody reads is lost once the queue is full.
    static_cast<void>(send(handle.fd, &event, sizeof event, MSG_DONTWAIT | MSG_NOSIGNAL));
  }
}

void FakeGpioChip::Drop(const Handle& handle) {
  close(handle.fd);
  for (unsigned line : handle.lines) {
    lines_[line].consumer.clear();
    if (std::exchange(lines_[line].output, false)) SetLevel(line, false);
  }
}

void FakeGpioChip::DropReleased() {
  for (auto it = handles_.begin(); it != handles_.end();) {
    pollfd descriptor{it->second.fd, POLLIN, 0};
    if (poll(&descriptor, 1, 0) > 0 && (descriptor.revents & (POLLHUP | POLLERR)) != 0) {
      const Handle released = std::move(it->second);
      it = handles_.erase(it);
      Drop(released);
    } else {
      ++it;
    }
  }
}

int FakeGpioChip::NewHandle(Handle handle, const char* consumer) {
  for (unsigned line : handle.lines) {
    if (line >= lines_.size()) return -EINVAL;
    if (!lines_[line].consumer.empty()) return -EBUSY;
  }
  int ends[2];
  if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends) != 0) return -errno;
  handle.fd = ends[0];
  for (unsigned line : handle.lines) {
    lines_[line].consumer = *consumer != '\0' ? consumer : "?";
    lines_[line].output = handle.output;
  }
  handles_[InodeOf(ends[1])] = std::move(handle);
  return ends[1];
}

int FakeGpioChip::HandleChip(unsigned long request, void* argument) {
  switch (request) {
    case GPIO_GET_CHIPINFO_IOCTL: {
      auto& info = *static_cast<gpiochip_info*>(argument);
      info = {};
      CopyName("gpiochip", info.name);
      CopyName(label_, info.label);
      info.lines = static_cast<unsigned>(lines_.size());
      return 0;
    }
    case GPIO_GET_LINEINFO_IOCTL: {
      auto& info = *static_cast<gpioline_info*>(argument);
      const unsigned number = info.line_offset;
      if (number >= lines_.size()) return -EINVAL;
      info = {};
      info.line_offset = number;
      CopyName(lines_[number].name, info.name);
      CopyName(lines_[number].consumer, info.consumer);
      info.flags = (lines_[number].consumer.empty() ? 0u : GPIOLINE_FLAG_KERNEL) |
                   (lines_[number].output ? GPIOLINE_FLAG_IS_OUT : 0u);
      return 0;
    }
    case GPIO_GET_LINEHANDLE_IOCTL: {
      auto& wanted = *static_cast<gpiohandle_request*>(argument);
      if (wanted.lines == 0 || wanted.lines > GPIOHANDLES_MAX) return -EINVAL;
      Handle handle;
      handle.lines.assign(wanted.lineoffsets, wanted.lineoffsets + wanted.lines);
      handle.output = (wanted.flags & GPIOHANDLE_REQUEST_OUTPUT) != 0;
      handle.active_low = (wanted.flags & GPIOHANDLE_REQUEST_ACTIVE_LOW) != 0;
      const Handle copy = handle;
      const int fd = NewHandle(std::move(handle), wanted.consumer_label);
      if (fd < 0) return fd;
      for (unsigned i = 0; i < wanted.lines && copy.output; ++i) {
        SetLevel(copy.lines[i], (wanted.default_values[i] != 0) != copy.active_low);
      }
      wanted.fd = fd;
      return 0;
    }
    case GPIO_GET_LINEEVENT_IOCTL: {
      auto& wanted = *static_cast<gpioevent_request*>(argument);
      Handle handle;
      handle.lines = {wanted.lineoffset};
      handle.active_low = (wanted.handleflags & GPIOHANDLE_REQUEST_ACTIVE_LOW) != 0;
      handle.edges = wanted.eventflags;
      const int fd = NewHandle(std::move(handle), wanted.consumer_label);
      if (fd < 0) return fd;
      wanted.fd = fd;
      return 0;
    }
    default: return -ENOTTY;
  }
}

int FakeGpioChip::Ioctl(int fd, unsigned long request, void* argument) {
  return IoctlOn(InodeOf(fd), request, argument);
}

int FakeGpioChip::IoctlOn(std::uint64_t inode, unsigned long request, void* argument) {
  std::unique_lock lock(mutex_);
  if (slow_.count() > 0) {
    const std::chrono::milliseconds time = slow_;
    lock.unlock();
    std::this_thread::sleep_for(time);
    lock.lock();
  }
  DropReleased();
  if (unplugged_) return -ENODEV;
  if (intermittent_ && ++calls_ % 2 == 0) return -EIO;
  if (failing_ > 0) {
    --failing_;
    return -EIO;
  }
  const auto found = handles_.find(inode);
  if (found == handles_.end()) return HandleChip(request, argument);
  const Handle& handle = found->second;
  auto& data = *static_cast<gpiohandle_data*>(argument);
  if (request == GPIOHANDLE_GET_LINE_VALUES_IOCTL) {
    for (std::size_t i = 0; i < handle.lines.size(); ++i) {
      data.values[i] = lines_[handle.lines[i]].high != handle.active_low;
    }
    return 0;
  }
  if (request != GPIOHANDLE_SET_LINE_VALUES_IOCTL) return -ENOTTY;
  if (!handle.output) return -EPERM;
  for (std::size_t i = 0; i < handle.lines.size() && !stuck_; ++i) {
    SetLevel(handle.lines[i], (data.values[i] != 0) != handle.active_low);
  }
  return 0;
}

void FakeGpioChip::SetNames(const std::vector<std::string>& names) {
  const std::lock_guard lock(mutex_);
  for (std::size_t i = 0; i < std::min(names.size(), lines_.size()); ++i) lines_[i].name = names[i];
}

void FakeGpioChip::SetSlow(std::chrono::milliseconds time) {
  const std::lock_guard lock(mutex_);
  slow_ = time;
}

void FakeGpioChip::SetIntermittent(bool intermittent) {
  const std::lock_guard lock(mutex_);
  intermittent_ = intermittent;
}

void FakeGpioChip::SetInput(unsigned line, bool high) {
  const std::lock_guard lock(mutex_);
  DropReleased();
  if (!lines_.at(line).output) SetLevel(line, high);
}

bool FakeGpioChip::level(unsigned line) {
  const std::lock_guard lock(mutex_);
  DropReleased();
  return lines_.at(line).high;
}

bool FakeGpioChip::is_output(unsigned line) {
  const std::lock_guard lock(mutex_);
  DropReleased();
  return lines_.at(line).output;
}

std::string FakeGpioChip::consumer(unsigned line) {
  const std::lock_guard lock(mutex_);
  DropReleased();
  return lines_.at(line).consumer;
}

int FakeGpioChip::rises(unsigned line) {
  const std::lock_guard lock(mutex_);
  return lines_.at(line).rises;
}

void FakeGpioChip::Unplug() {
  const std::lock_guard lock(mutex_);
  unplugged_ = true;
  for (const auto& [inode, handle] : std::exchange(handles_, {})) Drop(handle);
}

void FakeGpioChip::PlugIn() {
  const std::lock_guard lock(mutex_);
  unplugged_ = false;
}

void FakeGpioChip::SetStuck(bool stuck) {
  const std::lock_guard lock(mutex_);
  stuck_ = stuck;
}

void FakeGpioChip::FailCalls(int count) {
  const std::lock_guard lock(mutex_);
  failing_ = count;
}

}  // namespace geond::sim
