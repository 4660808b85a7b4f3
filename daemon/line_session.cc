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
  line += '\n';
  unsent_bytes_ += line.size();
  unsent_.push_back(std::move(line));
  if (unsent_bytes_ > limits_.max_unread) {
    spdlog::warn("a client leaves {} bytes unread and is dropped", unsent_bytes_);
    if (events_.on_slow) events_.on_slow();
    closing_ = true;
    // Not from within the list of clients that may be walked just now.
    asio::post(socket_.get_executor(), [self = shared_from_this()] { self->Close(); });
    return;
  }
  if (!writing_) Write();
}

void LineSession::Write() {
  writing_ = true;
  asio::async_write(socket_, asio::buffer(unsent_.front()),
                    [self = shared_from_this()](const boost::system::error_code& error, std::size_t) {
    self->writing_ = false;
    if (error || self->ended_) {
      self->Close();
      return;
    }
    self->unsent_bytes_ -= self->unsent_.front().size();
    self->unsent_.pop_front();
    if (!self->unsent_.empty()) {
      self->Write();
    } else if (self->closing_) {
      self->Close();
    }
  });
}

void LineSession::CloseWhenSent() {
  closing_ = true;
  if (!writing_) Close();
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
