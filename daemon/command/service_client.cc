// SPDX-License-Identifier: Apache-2.0
#include "daemon/command/service_client.h"

#include <cerrno>
#include <cstdlib>
#include <cstring>

#include <netdb.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include "core/base/error.h"
#include "core/base/progress.h"

namespace geond::daemon {
namespace {

constexpr char kDefaultSocket[] = "/run/geond/geond.sock";
constexpr char kDefaultTcp[] = "127.0.0.1:7100";
constexpr int kPollMs = 100;  // how soon a request to stop is noticed

int ConnectUnix(const std::string& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.size() >= sizeof address.sun_path) {
    errno = ENAMETOOLONG;
    return -1;
  }
  std::memcpy(address.sun_path, path.c_str(), path.size() + 1);
  const int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (fd >= 0 && connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
    const int error = errno;
    close(fd);
    errno = error;
    return -1;
  }
  return fd;
}

int ConnectTcp(const std::string& host, const std::string& port) {
  addrinfo hints{}, *found = nullptr;
  hints.ai_socktype = SOCK_STREAM;
  if (getaddrinfo(host.c_str(), port.c_str(), &hints, &found) != 0) {
    errno = EHOSTUNREACH;
    return -1;
  }
  int fd = -1, error = ECONNREFUSED;
  for (const addrinfo* each = found; each && fd < 0; each = each->ai_next) {
    fd = socket(each->ai_family, each->ai_socktype | SOCK_CLOEXEC, each->ai_protocol);
    if (fd >= 0 && connect(fd, each->ai_addr, each->ai_addrlen) != 0) {
      error = errno;
      close(fd);
      fd = -1;
    }
  }
  freeaddrinfo(found);
  errno = error;
  return fd;
}

}  // namespace

ServiceClient::ServiceClient(std::string address, std::stop_token stop) : address_(std::move(address)), stop_(stop) {
  if (address_.empty()) {
    const char* wanted = std::getenv("GEOND_SOCKET");
    // A user who is not in the service's group may still reach it over TCP.
    address_ = wanted && *wanted ? wanted : access(kDefaultSocket, R_OK | W_OK) == 0 ? kDefaultSocket : kDefaultTcp;
  }
  const std::size_t colon = address_.rfind(':');
  if (address_.find('/') != std::string::npos) {
    fd_ = ConnectUnix(address_);
  } else if (colon != std::string::npos) {
    fd_ = ConnectTcp(address_.substr(0, colon), address_.substr(colon + 1));
  } else {
    throw std::invalid_argument("'" + address_ + "' is neither the path of a socket nor host:port");
  }
  if (fd_ < 0) {
    throw DeviceError("geond", "connect to " + address_, std::strerror(errno),
                      "Start it (systemctl start geond, or geond --config config/geond.toml), or say where it is with --socket");
  }
  try {
    greeting_ = ReadLine();
    // The Unix socket is guarded by its mode; over TCP one may have to say who one is.
    if (const char* token = std::getenv("GEOND_TOKEN"); token && *token && address_.find('/') == std::string::npos) {
      Call("auth.login", {{"token", token}});
    }
  } catch (...) {
    close(fd_);
    throw;
  }
}

ServiceClient::~ServiceClient() { close(fd_); }

Json ServiceClient::ReadLine() {
  std::size_t searched = 0;
  while (true) {
    const std::size_t end = received_.find('\n', searched);
    if (end != std::string::npos) {
      Json line = Json::parse(received_.begin(), received_.begin() + static_cast<std::ptrdiff_t>(end), nullptr, false);
      received_.erase(0, end + 1);
      if (!line.is_object()) throw DeviceError("geond", "read", "the answer is not JSON", "Is it geond that listens there?");
      return line;
    }
    searched = received_.size();
    ThrowIfStopped(stop_);
    pollfd waiting{fd_, POLLIN, 0};
    if (poll(&waiting, 1, kPollMs) <= 0) continue;
    char buffer[1 << 16];
    const ssize_t n = read(fd_, buffer, sizeof buffer);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) throw DeviceError("geond", "read", "the service has closed the connection", "See its log (journalctl -u geond)");
    received_.append(buffer, static_cast<std::size_t>(n));
  }
}

Json ServiceClient::Call(const std::string& method, const Json& params) {
  const int id = next_id_++;
  const std::string line = Json{{"jsonrpc", "2.0"}, {"id", id}, {"method", method}, {"params", params}}.dump() + "\n";
  for (std::size_t sent = 0; sent < line.size();) {
    const ssize_t n = send(fd_, line.data() + sent, line.size() - sent, MSG_NOSIGNAL);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) throw DeviceError("geond", "send", std::strerror(errno), "See its log (journalctl -u geond)");
    sent += static_cast<std::size_t>(n);
  }
  while (true) {
    Json answer = ReadLine();
    if (answer.value("method", "") == "event") {
      events_.push_back(answer["params"]);
      continue;
    }
    if (!answer.contains("id") || (answer["id"] != id && !answer["id"].is_null())) continue;
    if (!answer.contains("error")) return answer["result"];
    const Json& error = answer["error"];
    throw RpcError(static_cast<RpcError::Code>(error.value("code", -32603)), error.value("message", ""),
                   error.contains("data") ? error["data"].value("remedy", "") : "");
  }
}

Json ServiceClient::NextEvent() {
  while (events_.empty()) {
    Json line = ReadLine();
    if (line.value("method", "") == "event") events_.push_back(line["params"]);
  }
  Json event = events_.front();
  events_.erase(events_.begin());
  return event;
}

}  // namespace geond::daemon
