// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <utility>

#include <boost/asio.hpp>
#include <boost/asio/ssl.hpp>
#include <boost/beast.hpp>
#include <boost/beast/ssl.hpp>

#include <memory>
#include <optional>
#include <string>

#include "daemon/http_port.h"

// One connection to the HTTP port, over TCP or TLS. Only http_port.cc and http_session.cc include this.
namespace geond::daemon {

namespace http = boost::beast::http;
using PlainStream = boost::beast::tcp_stream;
using TlsStream = boost::beast::ssl_stream<boost::beast::tcp_stream>;

// What all connections share.
struct HttpPortParts : std::enable_shared_from_this<HttpPortParts> {
  HttpPortParts(boost::asio::io_context& context, const HttpOptions& given, HttpHandlers use)
      : io(context), acceptor(context), options(given), handlers(std::move(use)) {}
  void Accept();

  boost::asio::io_context& io;
  boost::asio::ip::tcp::acceptor acceptor;
  const HttpOptions options;
  const HttpHandlers handlers;
  std::optional<boost::asio::ssl::context> tls;
  std::size_t clients = 0;
  std::uint64_t connections = 0;
  bool ended = false;  // the port is gone, and what the handlers lead to may be
};

// One HTTP connection: request after request. Kept alive by what it waits for.
template <typename Stream>
class HttpSession : public std::enable_shared_from_this<HttpSession<Stream>> {
 public:
  HttpSession(Stream stream, std::shared_ptr<HttpPortParts> parts);
  ~HttpSession();
  HttpSession(const HttpSession&) = delete;
  HttpSession& operator=(const HttpSession&) = delete;

  // After the handshake, if there is one.
  void Start();
  // Says that there are too many clients, and ends.
  void TurnAway();

 private:
  using Request = http::request<http::string_body>;
  using Response = http::response<http::string_body>;

  void Read();
  void ReadBody();
  void ReadArchive();
  Response Text(http::status status, std::string text, std::string_view type = "text/plain; charset=utf-8");
  Response ErrorText(http::status status, const RpcError& error);
  template <typename Body>
  void Answer(http::response<Body> response);
  void End();
  void Drain();
  std::string_view Header(http::field field) const;
  std::string_view Path() const;
  bool IsForeign() const;
  Role RoleOfRequest() const;
  void Handle();
  void HandleRpc();
  void HandleGet(std::string_view path);
  void AnswerArchive(int scan);
  void AnswerFile(const std::filesystem::path& file);

  Stream stream_;
  std::shared_ptr<HttpPortParts> parts_;
  std::uint64_t id_ = 0;
  boost::beast::flat_buffer received_;
  std::optional<http::request_parser<http::empty_body>> head_;
  std::optional<http::request_parser<http::string_body>> whole_;
  std::optional<http::request_parser<http::file_body>> archive_;
  Request request_;
  Client client_;
};

// Takes an HTTP connection over that asks to become a WebSocket: a request a message, answers and events as messages.
template <typename Stream>
void ServeWebSocket(Stream stream, const std::shared_ptr<HttpPortParts>& parts, std::uint64_t id,
                    const http::request<http::string_body>& request);

}  // namespace geond::daemon
