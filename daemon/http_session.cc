// SPDX-License-Identifier: Apache-2.0
#include "daemon/http_session.h"

#include <charconv>
#include <fstream>

#include "daemon/http_files.h"

namespace geond::daemon {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace fs = std::filesystem;
using boost::system::error_code;

namespace {

constexpr auto kPatience = std::chrono::seconds(60);
constexpr auto kFarewell = std::chrono::seconds(2);
constexpr std::string_view kScans = "/scans/";

// The number of a path like "/scans/7.zip" or, with a slash, "/scans/7/..."; 0: it is none.
int ScanOfPath(std::string_view path, std::string_view& rest) {
  if (path.substr(0, kScans.size()) != kScans) return 0;
  rest = path.substr(kScans.size());
  int scan = 0;
  const auto [end, bad] = std::from_chars(rest.data(), rest.data() + rest.size(), scan);
  if (bad != std::errc() || scan < 1) return 0;
  rest.remove_prefix(static_cast<std::size_t>(end - rest.data()));
  return scan;
}

http::status StatusOf(const RpcError& error) {
  switch (error.code()) {
    case RpcError::Code::kNotFound: return http::status::not_found;
    case RpcError::Code::kBusy: return http::status::conflict;
    case RpcError::Code::kUnavailable: return http::status::conflict;
    case RpcError::Code::kStorage: return http::status::unprocessable_entity;
    default: return http::status::internal_server_error;
  }
}

}  // namespace

template <typename Stream>
HttpSession<Stream>::HttpSession(Stream stream, std::shared_ptr<HttpPortParts> parts)
    : stream_(std::move(stream)), parts_(std::move(parts)) {
  ++parts_->clients;
  id_ = ++parts_->connections;
}

template <typename Stream>
HttpSession<Stream>::~HttpSession() {
  --parts_->clients;
}

template <typename Stream>
void HttpSession<Stream>::Start() {
  if constexpr (std::is_same_v<Stream, TlsStream>) {
    beast::get_lowest_layer(stream_).expires_after(kPatience);
    stream_.async_handshake(asio::ssl::stream_base::server, [self = this->shared_from_this()](const error_code& error) {
      if (!error) self->Read();
    });
  } else {
    Read();
  }
}

template <typename Stream>
void HttpSession<Stream>::TurnAway() {
  if constexpr (std::is_same_v<Stream, PlainStream>) {
    request_.keep_alive(false);
    Answer(ErrorText(http::status::service_unavailable,
                     RpcError(RpcError::Code::kTooManyClients,
                              "there are " + std::to_string(parts_->options.max_clients) + " clients already",
                              "Close one, or raise api.max_clients")));
  }
}

template <typename Stream>
void HttpSession<Stream>::Read() {
  head_.emplace();
  whole_.reset();
  head_->header_limit(16 << 10);
  head_->body_limit(parts_->options.max_archive);
  beast::get_lowest_layer(stream_).expires_after(kPatience);
  http::async_read_header(stream_, received_, *head_, [self = this->shared_from_this()](const error_code& error, std::size_t) {
    if (error == http::error::header_limit || error == http::error::body_limit) {
      self->request_.keep_alive(false);
      self->Answer(self->Text(http::status::payload_too_large, "The request is too large.\n"));
    } else if (!error) {
      self->request_.base() = self->head_->get().base();
      if (self->request_.method() == http::verb::post && self->Path() == "/scans") {
        self->ReadArchive();
      } else {
        self->ReadBody();
      }
    }
  });
}

template <typename Stream>
void HttpSession<Stream>::ReadBody() {
  if (head_->content_length().value_or(0) > parts_->options.max_body) {
    request_.keep_alive(false);
    return Answer(Text(http::status::payload_too_large, "The request is too large.\n"));
  }
  whole_.emplace(std::move(*head_));
  whole_->body_limit(parts_->options.max_body);  // of one that comes in chunks
  http::async_read(stream_, received_, *whole_, [self = this->shared_from_this()](const error_code& error, std::size_t) {
    if (error == http::error::body_limit) {
      self->request_.keep_alive(false);
      self->Answer(self->Text(http::status::payload_too_large, "The request is too large.\n"));
    } else if (!error) {
      self->request_ = self->whole_->release();
      self->Handle();
    }
  });
}

// An archive goes straight to disk, but only one that its sender may have taken in.
template <typename Stream>
void HttpSession<Stream>::ReadArchive() {
  request_.keep_alive(false);
  if (IsForeign() || RoleOfRequest() < Role::kAdmin) {
    return Answer(Text(http::status::forbidden, "Taking a scan in needs the role admin (Authorization: Bearer TOKEN).\n"));
  }
  const fs::path file = parts_->handlers.import_file();
  archive_.emplace(std::move(*head_));
  error_code error;
  archive_->get().body().open(file.c_str(), beast::file_mode::write, error);
  if (error) return Answer(Text(http::status::insufficient_storage, "The archive cannot be stored: " + error.message() + ".\n"));
  if (beast::iequals(Header(http::field::expect), "100-continue")) {
    http::response<http::empty_body> go_on(http::status::continue_, 11);
    http::write(stream_, go_on, error);
  }
  beast::get_lowest_layer(stream_).expires_after(10 * kPatience);
  http::async_read(stream_, received_, *archive_, [self = this->shared_from_this(), file](const error_code& failed, std::size_t) {
    self->archive_->get().body().close();
    if (failed) {
      std::error_code ignored;
      fs::remove(file, ignored);
      return self->Answer(self->Text(http::status::bad_request, "The archive did not come whole: " + failed.message() + ".\n"));
    }
    self->parts_->handlers.import_scan(file, [self](const geond::daemon::Answer& answer) {
      if (const RpcError* wrong = std::get_if<RpcError>(&answer)) return self->Answer(self->ErrorText(StatusOf(*wrong), *wrong));
      self->Answer(self->Text(http::status::created, std::get<Json>(answer).dump() + "\n", "application/json"));
    });
  });
}

template <typename Stream>
auto HttpSession<Stream>::Text(http::status status, std::string text, std::string_view type) -> Response {
  Response response(status, request_.version() ? request_.version() : 11);
  response.set(http::field::content_type, type);
  response.body() = std::move(text);
  return response;
}

template <typename Stream>
auto HttpSession<Stream>::ErrorText(http::status status, const RpcError& error) -> Response {
  return Text(status, Json{{"error", error.ToJson()}}.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n",
              "application/json");
}

template <typename Stream>
template <typename Body>
void HttpSession<Stream>::Answer(http::response<Body> response) {
  response.set(http::field::server, "geond");
  response.set("X-Content-Type-Options", "nosniff");
  response.set("X-Frame-Options", "DENY");
  response.set("Referrer-Policy", "no-referrer");
  response.set("Content-Security-Policy", "default-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data:");
  response.keep_alive(request_.keep_alive());
  response.prepare_payload();
  auto kept = std::make_shared<http::response<Body>>(std::move(response));
  auto writer = std::make_shared<http::response_serializer<Body>>(*kept);
  beast::get_lowest_layer(stream_).expires_after(kPatience);
  const auto done = [self = this->shared_from_this(), kept, writer](const error_code& error, std::size_t) {
    if (!error && kept->keep_alive()) {
      self->Read();
    } else {
      self->End();
    }
  };
  if (request_.method() == http::verb::head) {
    http::async_write_header(stream_, *writer, done);
  } else {
    http::async_write(stream_, *writer, done);
  }
}

template <typename Stream>
void HttpSession<Stream>::End() {
  if constexpr (std::is_same_v<Stream, TlsStream>) {
    stream_.async_shutdown([self = this->shared_from_this()](const error_code&) {});
  } else {
    error_code ignored;
    stream_.socket().shutdown(asio::ip::tcp::socket::shutdown_send, ignored);
    stream_.expires_after(kFarewell);
    Drain();
  }
}

// Closed with something unread, a connection would take the answer with it.
template <typename Stream>
void HttpSession<Stream>::Drain() {
  received_.clear();
  stream_.async_read_some(received_.prepare(4096), [self = this->shared_from_this()](const error_code& error, std::size_t) {
    if (!error) self->Drain();
  });
}

template <typename Stream>
std::string_view HttpSession<Stream>::Header(http::field field) const {
  const auto value = request_[field];
  return {value.data(), value.size()};
}

template <typename Stream>
std::string_view HttpSession<Stream>::Path() const {
  const std::string_view target(request_.target().data(), request_.target().size());
  return target.substr(0, target.find('?'));
}

// A web page from elsewhere must not move this machine's table.
template <typename Stream>
bool HttpSession<Stream>::IsForeign() const {
  const bool guarded = !parts_->handlers.tokens->empty();
  return (!guarded && !IsLoopbackName(Header(http::field::host))) ||
         (request_.count(http::field::origin) && !IsSameSite(Header(http::field::origin), Header(http::field::host)));
}

template <typename Stream>
Role HttpSession<Stream>::RoleOfRequest() const {
  if (parts_->handlers.tokens->empty()) return Role::kAdmin;
  constexpr std::string_view kBearer = "Bearer ";
  const std::string_view given = Header(http::field::authorization);
  return given.substr(0, kBearer.size()) == kBearer ? parts_->handlers.tokens->RoleOf(given.substr(kBearer.size())) : Role::kNone;
}

template <typename Stream>
void HttpSession<Stream>::Handle() {
  if (IsForeign()) return Answer(Text(http::status::forbidden, "Only pages of this machine may ask.\n"));
  const std::string_view path = Path();
  if (beast::websocket::is_upgrade(request_)) {
    if (path != "/ws") return Answer(Text(http::status::not_found, "There is a WebSocket at /ws only.\n"));
    beast::get_lowest_layer(stream_).expires_never();
    return ServeWebSocket(std::move(stream_), parts_, id_, request_);
  }
  client_.role = RoleOfRequest();
  if (client_.role < Role::kRead && (path == "/metrics" || path.substr(0, kScans.size()) == kScans)) {
    return Answer(Text(http::status::unauthorized, "A token is needed (Authorization: Bearer TOKEN).\n"));
  }
  if (path == "/rpc") return HandleRpc();
  if (request_.method() != http::verb::get && request_.method() != http::verb::head) {
    return Answer(Text(http::status::method_not_allowed, "Only GET, and POST at /rpc and /scans.\n"));
  }
  HandleGet(path);
}

template <typename Stream>
void HttpSession<Stream>::HandleRpc() {
  if (request_.method() != http::verb::post || Header(http::field::content_type).substr(0, 16) != "application/json") {
    return Answer(Text(http::status::bad_request, "POST a JSON-RPC request as application/json.\n"));
  }
  client_.id = id_;
  // A notification has no answer, but HTTP does.
  auto answered = std::make_shared<bool>(false);
  const bool wants_answer = request_.body().find("\"id\"") != std::string::npos;
  parts_->handlers.answer(request_.body(), client_, [self = this->shared_from_this(), answered](std::string text) {
    *answered = true;
    self->Answer(self->Text(http::status::ok, std::move(text), "application/json"));
  });
  if (!wants_answer && !*answered) Answer(Text(http::status::no_content, ""));
}

template <typename Stream>
void HttpSession<Stream>::HandleGet(std::string_view path) {
  if (path == "/metrics") return Answer(Text(http::status::ok, parts_->handlers.metrics(), "text/plain; version=0.0.4"));
  fs::path file;
  std::string_view rest;
  if (const int scan = ScanOfPath(path, rest); scan > 0) {
    if (rest == ".zip") return AnswerArchive(scan);
    if (rest.size() > 1 && rest[0] == '/' && IsPlainPath(rest.substr(1))) {
      file = parts_->handlers.scan_file(scan, std::string(rest.substr(1)));
    }
  } else {
    const std::string_view name = path == "/" ? std::string_view("index.html") : path.substr(path.empty() ? 0 : 1);
    if (IsPlainPath(name) && !parts_->options.page.empty()) file = parts_->options.page / name;
  }
  std::error_code none;
  if (file.empty() || !fs::is_regular_file(file, none)) {
    return Answer(Text(http::status::not_found, "There is no such file.\n"));
  }
  AnswerFile(file);
}

template <typename Stream>
void HttpSession<Stream>::AnswerArchive(int scan) {
  try {
    parts_->handlers.export_scan(scan, [self = this->shared_from_this()](const std::variant<fs::path, RpcError>& made) {
      if (const RpcError* error = std::get_if<RpcError>(&made)) return self->Answer(self->ErrorText(StatusOf(*error), *error));
      self->AnswerFile(std::get<fs::path>(made));
    });
  } catch (const RpcError& error) {
    Answer(ErrorText(StatusOf(error), error));
  }
}

template <typename Stream>
void HttpSession<Stream>::AnswerFile(const fs::path& file) {
  std::error_code unread;
  const std::uint64_t size = fs::file_size(file, unread);
  const auto written = fs::last_write_time(file, unread).time_since_epoch().count();
  if (unread) return Answer(Text(http::status::not_found, "There is no such file.\n"));
  const std::string tag = "\"" + std::to_string(size) + "-" + std::to_string(written) + "\"";
  const auto describe = [&](auto& response) {
    response.set(http::field::etag, tag);
    response.set(http::field::accept_ranges, "bytes");
    response.set(http::field::cache_control, "no-cache");
    response.set(http::field::content_type, ContentType(file));
  };
  Response response(http::status::ok, request_.version());
  describe(response);
  if (Header(http::field::if_none_match) == tag) {
    response.result(http::status::not_modified);
    return Answer(std::move(response));
  }
  const std::optional<ByteRange> part = ParseRange(Header(http::field::range), size);
  if (!part || (!Header(http::field::if_range).empty() && Header(http::field::if_range) != tag)) {
    http::response<http::file_body> whole(http::status::ok, request_.version());
    describe(whole);
    error_code error;
    whole.body().open(file.c_str(), beast::file_mode::scan, error);
    if (error) return Answer(Text(http::status::internal_server_error, "The file cannot be read.\n"));
    return Answer(std::move(whole));
  }
  if (part->length == 0) {
    response.result(http::status::range_not_satisfiable);
    response.set(http::field::content_range, "bytes */" + std::to_string(size));
    return Answer(std::move(response));
  }
  // No more in one answer than may wait for a reader; he asks for the rest.
  const std::uint64_t length = std::min<std::uint64_t>(part->length, parts_->options.max_unread);
  response.result(http::status::partial_content);
  response.set(http::field::content_range, "bytes " + std::to_string(part->first) + "-" +
                                               std::to_string(part->first + length - 1) + "/" + std::to_string(size));
  std::ifstream stream(file, std::ios::binary);
  response.body().resize(length);
  stream.seekg(static_cast<std::streamoff>(part->first));
  stream.read(response.body().data(), static_cast<std::streamsize>(length));
  if (!stream) return Answer(Text(http::status::internal_server_error, "The file cannot be read.\n"));
  Answer(std::move(response));
}

template class HttpSession<PlainStream>;
template class HttpSession<TlsStream>;

}  // namespace geond::daemon
