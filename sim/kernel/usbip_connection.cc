// SPDX-License-Identifier: Apache-2.0
#include "sim/kernel/usbip_connection.h"

#include <arpa/inet.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <set>

#include "sim/fake_usb_device.h"

namespace geond::sim {
namespace {

constexpr std::uint32_t kSubmit = 1, kUnlink = 2, kSubmitted = 3, kUnlinked = 4, kIn = 1;
constexpr std::uint32_t kNotIsochronous = 0xffffffff;
constexpr std::uint32_t kMostBytes = 64u << 20;             // of one transfer
constexpr std::chrono::milliseconds kTick(2);               // between looks at frames that are due
constexpr std::size_t kHeaderBytes = 48, kSetupAt = 40;

// Twelve numbers, most significant byte first. Of a request: command, number, device, direction, endpoint; then, to
// submit, flags, length, three of isochronous transfers and the setup packet; to unlink, the number meant.
class Header {
 public:
  std::uint32_t get(std::size_t word) const {
    std::uint32_t value;
    std::memcpy(&value, bytes.data() + 4 * word, 4);
    return ntohl(value);
  }
  void set(std::size_t word, std::uint32_t value) {
    value = htonl(value);
    std::memcpy(bytes.data() + 4 * word, &value, 4);
  }
  std::array<std::uint8_t, kHeaderBytes> bytes{};
};

bool ReadAll(int socket, void* to, std::size_t size) {
  auto* at = static_cast<std::uint8_t*>(to);
  while (size > 0) {
    const ssize_t count = recv(socket, at, size, 0);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return false;
    at += count;
    size -= static_cast<std::size_t>(count);
  }
  return true;
}

// Who has hung up is told nothing.
void WriteAll(int socket, const void* from, std::size_t size) {
  const auto* at = static_cast<const std::uint8_t*>(from);
  while (size > 0) {
    const ssize_t count = send(socket, at, size, MSG_NOSIGNAL);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return;
    at += count;
    size -= static_cast<std::size_t>(count);
  }
}

}  // namespace

UsbipConnection::UsbipConnection(FakeCamera& camera, int socket) : camera_(camera), socket_(socket) {
  server_ = std::jthread([this] { Serve(); });
  ticker_ = std::jthread([this](std::stop_token stop) {
    while (!stop.stop_requested()) {
      camera_.WaitForChange(kTick);
      CompleteWaiting();
    }
  });
}

UsbipConnection::~UsbipConnection() {
  shutdown(socket_, SHUT_RDWR);
  server_.join();
  ticker_ = {};
  close(socket_);
}

void UsbipConnection::Serve() {
  while (ServeOne()) {
  }
  shutdown(socket_, SHUT_RDWR);
}

bool UsbipConnection::ServeOne() {
  Header header;
  if (!ReadAll(socket_, header.bytes.data(), kHeaderBytes)) return false;
  const std::uint32_t number = header.get(1), length = header.get(6);
  if (header.get(0) == kUnlink) {
    Unlink(number, header.get(5));
    return true;
  }
  const std::uint32_t direction = header.get(3), endpoint = header.get(4);
  if (header.get(0) != kSubmit || length > kMostBytes || direction > kIn || endpoint > 15) return false;
  Request request;
  request.number = number;
  request.endpoint = static_cast<std::uint8_t>(endpoint | (direction == kIn ? 0x80u : 0u));
  std::copy_n(header.bytes.begin() + kSetupAt, 8, request.setup);
  request.data.resize(length);
  if (direction != kIn && !ReadAll(socket_, request.data.data(), length)) return false;
  {
    const std::lock_guard lock(mutex_);
    waiting_.push_back(std::move(request));
  }
  CompleteWaiting();
  return true;
}

bool UsbipConnection::Complete(Request& request) {
  int result = 0;
  if ((request.endpoint & 0x7f) == 0) {
    result = FakeUsbControl(camera_, request.setup, request.data);
  } else if (!request.data.empty()) {
    result = camera_.Transfer(request.endpoint, request.data);
  }
  if (result == FakeCamera::kNothingYet) return false;
  Header header;
  header.set(0, kSubmitted);
  header.set(1, request.number);
  header.set(5, static_cast<std::uint32_t>(std::min(result, 0)));
  header.set(6, static_cast<std::uint32_t>(std::max(result, 0)));
  header.set(8, kNotIsochronous);
  WriteAll(socket_, header.bytes.data(), kHeaderBytes);
  if ((request.endpoint & 0x80) != 0 && result > 0) {
    WriteAll(socket_, request.data.data(), static_cast<std::size_t>(result));
  }
  return true;
}

void UsbipConnection::CompleteWaiting() {
  const std::lock_guard lock(mutex_);
  std::set<std::uint8_t> blocked;
  for (auto request = waiting_.begin(); request != waiting_.end();) {
    const auto here = request++;
    if (blocked.contains(here->endpoint)) continue;
    if (Complete(*here)) {
      waiting_.erase(here);
    } else {
      blocked.insert(here->endpoint);
    }
  }
}

void UsbipConnection::Unlink(std::uint32_t answer, std::uint32_t number) {
  const std::lock_guard lock(mutex_);
  const auto meant = std::ranges::find(waiting_, number, &Request::number);
  Header header;
  header.set(0, kUnlinked);
  header.set(1, answer);
  header.set(5, meant != waiting_.end() ? static_cast<std::uint32_t>(-ECONNRESET) : 0);
  if (meant != waiting_.end()) waiting_.erase(meant);
  WriteAll(socket_, header.bytes.data(), kHeaderBytes);
}

}  // namespace geond::sim
