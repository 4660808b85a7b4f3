// SPDX-License-Identifier: Apache-2.0
#include "daemon/http_port.h"

#include <utility>

#include <boost/asio.hpp>
#include <boost/beast.hpp>

#include <charconv>
#include <deque>
#include <fstream>

#include "core/base/error.h"
#include "daemon/http_files.h"

namespace geond::daemon {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
using boost::system::error_code;
using Request = http::request<http::string_body>;
using Response = http::response<http::string_body>;

struct HttpPort::Parts : std::enable_shared_from_this<HttpPort::Parts> {
  Parts(asio::io_context& context, const HttpOptions& given, HttpHandlers use)
      : io(context), acceptor(context), options(given), handlers(std::move(use)) {}
  void Accept();

  asio::io_context& io;
  asio::ip::tcp::acceptor acceptor;
  const HttpOptions options;
  const HttpHandlers handlers;
  std::size_t clients = 0;
  std::uint64_t connections = 0;
};

namespace {

constexpr auto kPatience = std::chrono::seconds(60);

// A WebSocket: a request a message, answers and events as messages.
class WebSocketSession : public std::enable_shared_from_this<WebSocketSession> {
 public:
  template <typename P>
  WebSocketSession(beast::tcp_stream stream, P parts, std::uint64_t id)
      : socket_(std::move(stream)),
        handlers_(parts->handlers),
        max_unread_(parts->options.max_unread),
        max_message_(parts->options.max_body) {
    client_.id = id;
    client_.role = handlers_.tokens->empty() ? Role::kAdmin : Role::kNone;
  }

  void Start(const Request& request) {
    socket_.set_option(beast::websocket::stream_base::timeout::suggested(beast::role_type::server));
    socket_.read_message_max(max_message_);
    socket_.async_accept(request, [self = shared_from_this()](const error_code& error) {
      if (error) return;
      self->socket_.text(true);
      self->client_.send = [weak = self->weak_from_this()](std::string line) {
        if (const auto alive = weak.lock()) alive->Send(std::move(line));
      };
      self->handlers_.add_client(&self->client_);
      self->added_ = true;
      self->Send(self->handlers_.greeting());
      self->Read();
    });
  }

 private:
  void End() {
    if (std::exchange(added_, false)) handlers_.remove_client(&client_);
  }

  void Read() {
    socket_.async_read(received_, [self = shared_from_this()](const error_code& error, std::size_t) {
      if (error) return self->End();
      const std::string line = beast::buffers_to_string(self->received_.data());
      self->received_.consume(self->received_.size());
      self->handlers_.methods->Handle(line, self->client_, self->client_.send);
      self->Read();
    });
  }

  void Send(std::string line) {
    unsent_bytes_ += line.size();
    unsent_.push_back(std::move(line));
    if (unsent_bytes_ > max_unread_) {
      End();
      beast::get_lowest_layer(socket_).close();
    } else if (unsent_.size() == 1) {
      Write();
    }
  }

  void Write() {
    socket_.async_write(asio::buffer(unsent_.front()), [self = shared_from_this()](const error_code& error, std::size_t) {
      if (error) return self->End();
      self->unsent_bytes_ -= self->unsent_.front().size();
      self->unsent_.pop_front();
      if (!self->unsent_.empty()) self->Write();
    });
  }

  beast::websocket::stream<beast::tcp_stream> socket_;
  const HttpHandlers handlers_;
  const std::size_t max_unread_, max_message_;
  beast::flat_buffer received_;
  Client client_;
  bool added_ = false;
  std::deque<std::string> unsent_;
  std::size_t unsent_bytes_ = 0;
};

// One HTTP connection: request after request.
template <typename P>
class HttpSession : public std::enable_shared_from_this<HttpSession<P>> {
 public:
  HttpSession(asio::ip::tcp::socket socket, P parts) : stream_(std::move(socket)), parts_(std::move(parts)) {
    ++parts_->clients;
    id_ = ++parts_->connections;
  }
  ~HttpSession() { --parts_->clients; }

  void Read() {
    parser_.emplace();
    parser_->body_limit(parts_->options.max_body);
    parser_->header_limit(16 << 10);
    stream_.expires_after(kPatience);
    http::async_read(stream_, received_, *parser_, [self = this->shared_from_this()](const error_code& error, std::size_t) {
      if (error == http::error::body_limit || error == http::error::header_limit) {
        self->Answer(self->Text(http::status::payload_too_large, "The request is too large.\n"));
      } else if (!error) {
        self->request_ = self->parser_->release();
        self->Handle();
      }
    });
  }

 private:
  Response Text(http::status status, std::string text, std::string_view type = "text/plain; charset=utf-8") {
    Response response(status, request_.version() ? request_.version() : 11);
    response.set(http::field::content_type, type);
    response.body() = std::move(text);
    return response;
  }

  void Answer(Response response) {
    response.set(http::field::server, "geond");
    response.set("X-Content-Type-Options", "nosniff");
    response.set("Content-Security-Policy", "default-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data:");
    response.keep_alive(request_.keep_alive());
    response.prepare_payload();
    if (request_.method() == http::verb::head) response.body().clear();
    auto kept = std::make_shared<Response>(std::move(response));
    stream_.expires_after(kPatience);
    http::async_write(stream_, *kept, [self = this->shared_from_this(), kept](const error_code& error, std::size_t) {
      if (!error && kept->keep_alive()) {
        self->Read();
      } else {
        error_code ignored;
        self->stream_.socket().shutdown(asio::ip::tcp::socket::shutdown_send, ignored);
      }
    });
  }

  void Handle() {
    const std::string_view target(request_.target().data(), request_.target().size());
    const std::string_view path = target.substr(0, target.find('?'));
    const auto header = [&](http::field field) {
      return std::string_view(request_[field].data(), request_[field].size());
    };
    // A web page from elsewhere must not move this machine's table.
    const bool guarded = !parts_->handlers.tokens->empty();
    if ((!guarded && !IsLoopbackName(header(http::field::host))) ||
        (request_.count(http::field::origin) && !IsSameSite(header(http::field::origin), header(http::field::host)))) {
      return Answer(Text(http::status::forbidden, "Only pages of this machine may ask.\n"));
    }
    if (beast::websocket::is_upgrade(request_)) {
      if (path != "/ws") return Answer(Text(http::status::not_found, "There is a WebSocket at /ws only.\n"));
      stream_.expires_never();
      std::make_shared<WebSocketSession>(std::move(stream_), parts_, id_)->Start(request_);
      return;
    }
    constexpr std::string_view kBearer = "Bearer ";
    const std::string_view authorization = header(http::field::authorization);
    client_.role = !guarded ? Role::kAdmin
                   : authorization.substr(0, kBearer.size()) == kBearer
                       ? parts_->handlers.tokens->RoleOf(authorization.substr(kBearer.size()))
                       : Role::kNone;
    if (client_.role < Role::kRead && (path == "/metrics" || path.substr(0, 7) == "/scans/")) {
      return Answer(Text(http::status::unauthorized, "A token is needed (Authorization: Bearer TOKEN).\n"));
    }
    if (path == "/rpc") return HandleRpc(header(http::field::content_type));
    if (request_.method() != http::verb::get && request_.method() != http::verb::head) {
      return Answer(Text(http::status::method_not_allowed, "Only GET, and POST at /rpc.\n"));
    }
    if (path == "/metrics") return Answer(Text(http::status::ok, parts_->handlers.metrics(), "text/plain; version=0.0.4"));
    HandleFile(path);
  }

  void HandleRpc(std::string_view content_type) {
    if (request_.method() != http::verb::post || content_type.substr(0, 16) != "application/json") {
      return Answer(Text(http::status::bad_request, "POST a JSON-RPC request as application/json.\n"));
    }
    client_.id = id_;
    parts_->handlers.methods->Handle(request_.body(), client_, [self = this->shared_from_this()](std::string text) {
      self->Answer(self->Text(http::status::ok, std::move(text), "application/json"));
    });
  }

  void HandleFile(std::string_view path) {
    std::filesystem::path file;
    constexpr std::string_view kScans = "/scans/";
    if (path.substr(0, kScans.size()) == kScans) {
      const std::string_view rest = path.substr(kScans.size());
      const std::size_t slash = rest.find('/');
      int scan = 0;
      const auto [end, bad] = std::from_chars(rest.data(), rest.data() + std::min(slash, rest.size()), scan);
      if (slash != std::string_view::npos && bad == std::errc() && end == rest.data() + slash && IsPlainPath(rest.substr(slash + 1))) {
        file = parts_->handlers.scan_file(scan, std::string(rest.substr(slash + 1)));
      }
    } else {
      const std::string_view name = path == "/" ? std::string_view("index.html") : path.substr(path.empty() ? 0 : 1);
      if (IsPlainPath(name) && !parts_->options.page.empty()) file = parts_->options.page / name;
    }
    error_code ignored;
    std::error_code none;
    if (file.empty() || !std::filesystem::is_regular_file(file, none)) {
      return Answer(Text(http::status::not_found, "There is no such file.\n"));
    }
    AnswerFile(file);
  }

  void AnswerFile(const std::filesystem::path& file) {
    std::error_code error;
    const std::uint64_t size = std::filesystem::file_size(file, error);
    const auto written = std::filesystem::last_write_time(file, error).time_since_epoch().count();
    const std::string tag = "\"" + std::to_string(size) + "-" + std::to_string(written) + "\"";
    Response response(http::status::ok, request_.version());
    response.set(http::field::etag, tag);
    response.set(http::field::accept_ranges, "bytes");
    response.set(http::field::cache_control, "no-cache");
    response.set(http::field::content_type, ContentType(file));
    if (request_[http::field::if_none_match] == tag) {
      response.result(http::status::not_modified);
      return Answer(std::move(response));
    }
    ByteRange range{0, size};
    const std::string_view wanted(request_[http::field::range].data(), request_[http::field::range].size());
    if (const std::optional<ByteRange> part = ParseRange(wanted, size);
        part && (request_[http::field::if_range].empty() || request_[http::field::if_range] == tag)) {
      if (part->length == 0) {
        response.result(http::status::range_not_satisfiable);
        response.set(http::field::content_range, "bytes */" + std::to_string(size));
        return Answer(std::move(response));
      }
      range = *part;
      response.result(http::status::partial_content);
      response.set(http::field::content_range, "bytes " + std::to_string(range.first) + "-" +
                                                   std::to_string(range.first + range.length - 1) + "/" + std::to_string(size));
    }
    std::ifstream stream(file, std::ios::binary);
    response.body().resize(range.length);
    stream.seekg(static_cast<std::streamoff>(range.first));
    stream.read(response.body().data(), static_cast<std::streamsize>(range.length));
    if (!stream) return Answer(Text(http::status::internal_server_error, "The file cannot be read.\n"));
    Answer(std::move(response));
  }

  beast::tcp_stream stream_;
  P parts_;
  std::uint64_t id_ = 0;
  beast::flat_buffer received_;
  std::optional<http::request_parser<http::string_body>> parser_;
  Request request_;
  Client client_;
};

}  // namespace

void HttpPort::Parts::Accept() {
  acceptor.async_accept([weak = weak_from_this()](const error_code& error, asio::ip::tcp::socket socket) {
    const auto self = weak.lock();
    if (!self || error == asio::error::operation_aborted) return;
    if (!error && self->clients < self->options.max_clients) {
      std::make_shared<HttpSession<std::shared_ptr<Parts>>>(std::move(socket), self)->Read();
    }
    self->Accept();
  });
}

HttpPort::HttpPort(void* io_context, const HttpOptions& options, HttpHandlers handlers)
    : parts_(std::make_shared<Parts>(*static_cast<asio::io_context*>(io_context), options, std::move(handlers))) {
  try {
    const asio::ip::tcp::endpoint endpoint(asio::ip::make_address(options.address), static_cast<std::uint16_t>(options.port));
    if (!endpoint.address().is_loopback() && parts_->handlers.tokens->empty()) {
      throw ConfigError("geond.toml", "http.address", options.address + " can be reached from outside, and there are no tokens",
                        "Use 127.0.0.1, or name a file of tokens (api.tokens)");
    }
    parts_->acceptor.open(endpoint.protocol());
    parts_->acceptor.set_option(asio::ip::tcp::acceptor::reuse_address(true));
    parts_->acceptor.bind(endpoint);
    parts_->acceptor.listen();
  } catch (const boost::system::system_error& failure) {
    throw ConfigError("geond.toml", "http.port", std::to_string(options.port) + " cannot be used: " + failure.code().message(),
                      "Another program listens there; choose another port, 0 for any or -1 for none");
  }
  parts_->Accept();
}

HttpPort::~HttpPort() {
  error_code ignored;
  parts_->acceptor.close(ignored);
}

int HttpPort::port() const { return parts_->acceptor.local_endpoint().port(); }

}  // namespace geond::daemon
