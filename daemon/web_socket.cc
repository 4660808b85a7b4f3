// SPDX-License-Identifier: Apache-2.0
#include <deque>

#include "daemon/http_session.h"

namespace geond::daemon {

namespace asio = boost::asio;
namespace beast = boost::beast;
using boost::system::error_code;

namespace {

template <typename Stream>
class WebSocketSession : public std::enable_shared_from_this<WebSocketSession<Stream>> {
 public:
  WebSocketSession(Stream stream, std::shared_ptr<HttpPortParts> parts, std::uint64_t id)
      : socket_(std::move(stream)), parts_(std::move(parts)) {
    ++parts_->clients;
    client_.id = id;
    client_.role = parts_->handlers.tokens->empty() ? Role::kAdmin : Role::kNone;
  }
  ~WebSocketSession() {
    End();
    --parts_->clients;
  }

  void Start(const http::request<http::string_body>& request) {
    socket_.set_option(beast::websocket::stream_base::timeout::suggested(beast::role_type::server));
    socket_.read_message_max(parts_->options.max_body);
    socket_.async_accept(request, [self = this->shared_from_this()](const error_code& error) {
      if (error) return;
      self->socket_.text(true);
      self->client_.send = [weak = self->weak_from_this()](std::string line) {
        if (const auto alive = weak.lock()) alive->Send(std::move(line));
      };
      self->parts_->handlers.add_client(&self->client_);
      self->added_ = true;
      self->Send(self->parts_->handlers.greeting());
      self->Read();
    });
  }

 private:
  void End() {
    if (std::exchange(added_, false) && !parts_->ended) parts_->handlers.remove_client(&client_);
  }

  void Read() {
    socket_.async_read(received_, [self = this->shared_from_this()](const error_code& error, std::size_t) {
      if (error) return self->End();
      const std::string line = beast::buffers_to_string(self->received_.data());
      self->received_.consume(self->received_.size());
      self->parts_->handlers.answer(line, self->client_, self->client_.send);
      self->Read();
    });
  }

  void Send(std::string line) {
    if (dropped_) return;
    unsent_bytes_ += line.size();
    unsent_.push_back(std::move(line));
    if (unsent_bytes_ > parts_->options.max_unread) {
      dropped_ = true;
      parts_->handlers.refused("slow_reader");
      // Not from within the list of clients that may be walked just now.
      asio::post(socket_.get_executor(), [self = this->shared_from_this()] {
        self->End();
        beast::get_lowest_layer(self->socket_).close();
      });
    } else if (unsent_.size() == 1) {
      Write();
    }
  }

  void Write() {
    socket_.async_write(asio::buffer(unsent_.front()),
                        [self = this->shared_from_this()](const error_code& error, std::size_t) {
                          if (error) return self->End();
                          self->unsent_bytes_ -= self->unsent_.front().size();
                          self->unsent_.pop_front();
                          if (!self->unsent_.empty()) self->Write();
                        });
  }

  beast::websocket::stream<Stream> socket_;
  const std::shared_ptr<HttpPortParts> parts_;
  beast::flat_buffer received_;
  Client client_;
  bool added_ = false, dropped_ = false;
  std::deque<std::string> unsent_;
  std::size_t unsent_bytes_ = 0;
};

}  // namespace

template <typename Stream>
void ServeWebSocket(Stream stream, const std::shared_ptr<HttpPortParts>& parts, std::uint64_t id,
                    const http::request<http::string_body>& request) {
  std::make_shared<WebSocketSession<Stream>>(std::move(stream), parts, id)->Start(request);
}

template void ServeWebSocket(PlainStream, const std::shared_ptr<HttpPortParts>&, std::uint64_t,
                             const http::request<http::string_body>&);
template void ServeWebSocket(TlsStream, const std::shared_ptr<HttpPortParts>&, std::uint64_t,
                             const http::request<http::string_body>&);

}  // namespace geond::daemon
