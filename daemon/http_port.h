// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <variant>

#include "daemon/access_tokens.h"
#include "daemon/rpc.h"

namespace geond::daemon {

struct HttpOptions {
  std::string address = "127.0.0.1";       // loopback
  int port = 7180;                         // 0: any free one
  std::filesystem::path page;              // folder of the page; what is not there is not served
  std::filesystem::path certificate, key;  // PEM; empty: no TLS
  std::size_t max_clients = 256;
  std::size_t max_body = 1 << 20;                      // bytes of a request
  std::size_t max_unread = 8 << 20;                    // bytes that wait for a WebSocket to read them
  std::uint64_t max_archive = std::uint64_t{1} << 30;  // bytes of a scan that is taken in
};

// What the port asks of the rest of the program; all on the I/O thread.
struct HttpHandlers {
  // Answers a request; as Service::Answer.
  std::function<void(std::string_view line, Client&, const std::function<void(std::string)>& respond)> answer;
  const AccessTokens* tokens = nullptr;   // empty: everybody on this machine may do everything
  std::function<std::string()> greeting;  // first line of a WebSocket
  std::function<void(Client*)> add_client, remove_client;
  // The file of a scan, by number and name ("mesh.ply"); empty if there is none.
  std::function<std::filesystem::path(int scan, const std::string& name)> scan_file;
  // The archive of a scan, now or later; throws RpcError.
  std::function<void(int scan, const std::function<void(std::variant<std::filesystem::path, RpcError>)>&)> export_scan;
  std::function<std::filesystem::path()> import_file;  // where to put an archive that comes in, ...
  std::function<void(const std::filesystem::path&, const Reply&)> import_scan;  // ... and what to do with it then
  std::function<std::string()> metrics;                                         // text for Prometheus
  std::function<void(const std::string& why)> refused;  // told of clients that are turned away or dropped
};

// Throws ConfigError if the certificate and its key (PEM) cannot be used, or others can read the key.
void CheckCertificate(const std::filesystem::path& certificate, const std::filesystem::path& key);

// The same methods over HTTP (POST /rpc) and WebSocket (/ws), the files of scans (GET /scans/7/mesh.ply, with Range and
// ETag), whole scans (GET /scans/7.zip, POST /scans), the page, and /metrics; over TLS if there is a certificate. Lives
// on the I/O thread. Requests that a foreign web page makes through a browser are refused by their Host and Origin.
// With tokens, everything but the page itself needs one (Authorization: Bearer TOKEN, or auth.login on a WebSocket).
class HttpPort {
 public:
  // `io_context` is a boost::asio::io_context. Throws ConfigError if port, certificate or key cannot be used.
  HttpPort(void* io_context, const HttpOptions& options, HttpHandlers handlers);
  ~HttpPort();
  int port() const;

 private:
  std::shared_ptr<struct HttpPortParts> parts_;
};

}  // namespace geond::daemon
