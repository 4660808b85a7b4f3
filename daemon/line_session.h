// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <utility>

#include <boost/asio.hpp>

#include <array>
#include <functional>
#include <memory>
#include <string>

namespace geond::daemon {

struct LineLimits {
  std::size_t max_line = 1 << 20;    // bytes of a request
  std::size_t max_unread = 8 << 20;  // bytes that wait for a client to read them
  bool cr_ends_line = false;         // as well as LF does
};

// A connection that speaks lines. Lives on the I/O thread; kept alive by what it waits for, so that it ends with its socket.
class LineSession : public std::enable_shared_from_this<LineSession> {
 public:
  using Socket = boost::asio::generic::stream_protocol::socket;
  struct Events {
    std::function<void(std::string_view line)> on_line;  // without its newline
    std::function<void()> on_end;                        // once
    std::function<void()> on_slow;                       // before it is dropped for leaving too much unread
    std::function<std::string()> too_long;               // what is said before a line that is closes the connection
  };
  LineSession(Socket socket, LineLimits limits) : socket_(std::move(socket)), limits_(limits) {}

  void Start(Events events);
  // Sends a line; drops the connection if its client reads too slowly.
  void Send(std::string line);
  // Closes it after what was sent before.
  void CloseWhenSent();
  void Close();

 private:
  void Read();
  void TakeLines();
  void Write();

  Socket socket_;
  const LineLimits limits_;
  Events events_;
  std::array<char, 16384> buffer_;
  std::string received_;
  std::size_t searched_ = 0;  // of received_, without a line's end
  std::string sending_, unsent_;  // on its way, and what waits for the next write: all of it at once
  bool closing_ = false, ended_ = false;
};

}  // namespace geond::daemon
