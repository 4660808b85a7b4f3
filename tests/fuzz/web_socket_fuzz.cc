// SPDX-License-Identifier: Apache-2.0
// Whatever frames a browser sends, as the WebSocket reads them.
#include <utility>

#include <boost/asio.hpp>
#include <boost/beast.hpp>
#include <boost/beast/_experimental/test/stream.hpp>

#include <cstdint>
#include <string>

#include "tests/fuzz/check.h"

namespace {

namespace beast = boost::beast;

void Frames(const std::string& text) {
  boost::asio::io_context io;
  beast::test::stream wire(io), other(io);
  wire.connect(other);
  beast::websocket::stream<beast::test::stream> socket(std::move(wire));
  socket.read_message_max(1 << 14);
  boost::asio::write(other,
                     boost::asio::buffer(std::string("GET /ws HTTP/1.1\r\nHost: a\r\nUpgrade: websocket\r\nConnection: "
                                                     "Upgrade\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
                                                     "Sec-WebSocket-Version: 13\r\n\r\n")));
  boost::system::error_code error;
  socket.accept(error);
  Check(!error);
  boost::asio::write(other, boost::asio::buffer(text), error);
  other.close();
  beast::flat_buffer message;
  while (!error) {
    socket.read(message, error);
    Check(message.size() <= 1 << 14);
    message.clear();
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Frames(std::string(reinterpret_cast<const char*>(data), size));
  return 0;
}
