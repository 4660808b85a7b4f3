// SPDX-License-Identifier: Apache-2.0
#include "daemon/line_session.h"

#include <algorithm>

#include <spdlog/spdlog.h>

namespace geond::daemon {

namespace asio = boost::asio;

void LineSession::Start(Events events) {
  events_ = std::move(events);
  Read();
}

void LineSession::Read() {
  socket_.async_read_some(asio::buffer(buffer_), [self = shared_from_this()](const boost::system::error_code& error, std::size_t n) {
    if (error) {
      self->Close();
      return;
    }
    self->received_.append(self->buffer_.data(), n);
    self->TakeLines();
    if (!self->closing_ && !self->ended_) self->Read();
  });
}

void LineSession::TakeLines() {
  const char* const ends = limits_.cr_ends_line ? "\r\n" : "\n";
  std::size_t begin = 0;
  for (std::size_t end; (end = received_.find_first_of(ends, std::max(begin, searched_))) != std::string::npos; begin = end + 1) {
    std::string_view line(received_.data() + begin, end - begin);
    if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
    if (line.size() > limits_.max_line) {
      begin = 0;
      break;
    }
    if (!line.empty()) events_.on_line(line);
    if (closing_ || ended_) return;
  }
  received_.erase(0, begin);
  searched_ = received_.size();
  if (received_.size() > limits_.max_line) {
    Send(events_.too_long());
    CloseWhenSent();
  }
}

void LineSession::Send(std::string line) {
  if (ended_ || closing_) return;
  unsent_ += line;
  unsent_ += '\n';
  if (const std::size_t unread = sending_.size() + unsent_.size(); unread > limits_.max_unread) {
    spdlog::warn("a client leaves {} bytes unread and is dropped", unread);
    if (events_.on_slow) events_.on_slow();
    closing_ = true;
    // Not from within the list of clients that may be walked just now.
    asio::post(socket_.get_executor(), [self = shared_from_this()] { self->Close(); });
    return;
  }
  if (sending_.empty()) Write();
}

// A client that sends many lines at once gets its answers as fast as it reads, not one a turn of the loop.
void LineSession::Write() {
  sending_.swap(unsent_);
  asio::async_write(socket_, asio::buffer(sending_),
                    [self = shared_from_this()](const boost::system::error_code& error, std::size_t) {
    self->sending_ = {};  // its memory too: a burst may have been long
    if (error || self->ended_) {
      self->Close();
      return;
    }
    if (!self->unsent_.empty()) {
      self->Write();
    } else if (self->closing_) {
      self->Close();
    }
  });
}

void LineSession::CloseWhenSent() {
  closing_ = true;
  if (sending_.empty()) Close();
}

void LineSession::Close() {
  if (ended_) return;
  ended_ = true;
  boost::system::error_code ignored;
  socket_.shutdown(Socket::shutdown_both, ignored);
  socket_.close(ignored);
  if (events_.on_end) events_.on_end();
  // Callbacks may own what owns a session; let go after they have returned.
  asio::post(socket_.get_executor(), [self = shared_from_this()] { self->events_ = {}; });
}

}  // namespace geond::daemon
