// SPDX-License-Identifier: Apache-2.0
// Whatever a drive replies, on TCP and by the driver of turntables: values or a named error, never a crash, and nothing
// that was not asked for taken for an answer. The input is cut into replies; each begins with its length and a flag.
#include <arpa/inet.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <cstdint>
#include <cstdlib>
#include <mutex>
#include <thread>
#include <vector>

#include "core/base/error.h"
#include "drivers/modbus_link.h"

namespace {

using namespace geond;
using namespace geond::drivers;

// Answers each request with the next piece of the input; with its flag set, behind a header that fits the request.
class Drive {
 public:
  Drive() {
    listener_ = socket(AF_INET, SOCK_STREAM, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    if (bind(listener_, reinterpret_cast<sockaddr*>(&address), size) != 0 || listen(listener_, 8) != 0) std::abort();
    getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size);
    port_ = ntohs(address.sin_port);
    std::thread([this] { Serve(); }).detach();
  }
  int port() const { return port_; }
  void SetReplies(std::vector<std::uint8_t> bytes) {
    const std::lock_guard lock(mutex_);
    replies_ = std::move(bytes);
    at_ = 0;
  }

 private:
  std::vector<std::uint8_t> NextReply(const std::uint8_t* request) {
    const std::lock_guard lock(mutex_);
    std::vector<std::uint8_t> reply;
    if (at_ + 1 >= replies_.size()) return reply;
    const std::size_t size = replies_[at_] % 64;
    const bool fits = replies_[at_ + 1] % 2 == 0;
    at_ += 2;
    const std::size_t end = std::min(replies_.size(), at_ + size);
    if (fits) {
      reply = {request[0], request[1], 0, 0, 0, static_cast<std::uint8_t>(end - at_ + 1), request[6]};
    }
    reply.insert(reply.end(), replies_.begin() + static_cast<std::ptrdiff_t>(at_),
                 replies_.begin() + static_cast<std::ptrdiff_t>(end));
    at_ = end;
    return reply;
  }
  void Serve() {
    while (true) {
      const int client = accept(listener_, nullptr, nullptr);
      std::uint8_t request[300];
      while (recv(client, request, sizeof request, 0) > 0) {
        const std::vector<std::uint8_t> reply = NextReply(request);
        if (reply.empty()) break;
        if (send(client, reply.data(), reply.size(), MSG_NOSIGNAL) < 0) break;
      }
      close(client);
    }
  }
  int listener_ = -1, port_ = 0;
  std::mutex mutex_;
  std::vector<std::uint8_t> replies_;
  std::size_t at_ = 0;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static Drive& drive = *new Drive;  // its thread outlives main
  drive.SetReplies({data, data + size});
  ModbusAddress address;
  address.host = "127.0.0.1";
  address.port = drive.port();
  address.response_timeout = std::chrono::milliseconds(20);
  ModbusLink link("drive", address, 0x7e);
  for (int request = 0; request < 4; ++request) {
    try {
      if (request % 2 == 0) {
        if (link.Read(0x7e, 2).size() != 2) std::abort();
      } else {
        const std::uint16_t words[] = {1, 2};
        link.Write(0x7c, words);
      }
    } catch (const DeviceError&) {
    }
  }
  return 0;
}
