// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "daemon/access_tokens.h"
#include "daemon/rpc.h"

namespace geond::daemon {

struct HttpOptions {
  std::string address = "127.0.0.1";       // loopback
  int port = 7180;                         // 0: any free one
  std::filesystem::path page;              // folder of the page; what is not there is not served
  std::size_t max_clients = 256;
  std::size_t max_body = 1 << 20;          // bytes of a request
  std::size_t max_unread = 8 << 20;        // bytes that wait for a WebSocket to read them
};

// What the port asks of the rest of the program; all on the I/O thread.
struct HttpHandlers {
  const RpcTable* methods = nullptr;
  const AccessTokens* tokens = nullptr;              // empty: everybody on this machine may do everything
  std::function<std::string()> greeting;             // first line of a WebSocket
  std::function<void(Client*)> add_client, remove_client;
  // The file of a scan, by number and name ("mesh.ply"); empty if there is none.
  std::function<std::filesystem::path(int scan, const std::string& name)> scan_file;
  std::function<std::string()> metrics;              // text for Prometheus
};

// The same methods over HTTP (POST /rpc) and WebSocket (/ws), the files of scans (GET /scans/7/mesh.ply, with Range and
// ETag), the page, and /metrics. Lives on the I/O thread. Requests that a foreign web page makes through a browser are
// refused by their Host and Origin. With tokens, everything but the page itself needs one (Authorization: Bearer TOKEN, or
// auth.login on a WebSocket).
class HttpPort {
 public:
  // `io_context` is a boost::asio::io_context. Throws ConfigError if the port cannot be used.
  HttpPort(void* io_context, const HttpOptions& options, HttpHandlers handlers);
  ~HttpPort();
  int port() const;

 private:
  struct Parts;
  std::shared_ptr<Parts> parts_;
};

}  // namespace geond::daemon
