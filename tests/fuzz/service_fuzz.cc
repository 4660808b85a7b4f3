// SPDX-License-Identifier: Apache-2.0
// Whatever a client, a robot, a configuration or a stored file says: an answer or a named error, never a crash. The first
// byte chooses which of them it is.
#include <utility>

#include <boost/asio.hpp>
#include <boost/beast.hpp>
#include <boost/beast/_experimental/test/stream.hpp>

#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include <unistd.h>

#include "core/base/error.h"
#include "daemon/config.h"
#include "daemon/exposure_file.h"
#include "daemon/http_files.h"
#include "daemon/robot/allow_list.h"
#include "daemon/robot/robot_protocol.h"
#include "daemon/rpc.h"
#include "daemon/scan_archive.h"
#include "daemon/scan_recorder.h"

namespace {

using namespace geond;
using namespace geond::daemon;

RpcTable Table() {
  RpcTable table;
  table.Add({"scan.start", Role::kScan,
             {{"views", "integer", "", false, 1, 360, {}}, {"label", "string", "", false, 0, 0, {"a", "b"}},
              {"angle", "number", "", true, -360, 360, {}}},
             {}, "", [](const Json& params, Client&, const Reply& reply) { reply(params); }});
  return table;
}

void Check(bool holds) {
  if (!holds) std::abort();
}

namespace beast = boost::beast;

// A request as the HTTP port reads it, and what it asks of it.
void Http(const std::string& text) {
  beast::http::request_parser<beast::http::string_body> parser;
  parser.eager(true);
  parser.header_limit(16 << 10);
  parser.body_limit(1 << 16);
  boost::system::error_code error;
  const std::size_t used = parser.put(boost::asio::buffer(text), error);
  Check(used <= text.size());
  if (error || !parser.is_header_done()) return;
  const auto header = [&](beast::http::field field) {
    const auto value = parser.get()[field];
    return std::string_view(value.data(), value.size());
  };
  IsSameSite(header(beast::http::field::origin), header(beast::http::field::host));
  ParseRange(header(beast::http::field::range), 1000);
  IsPlainPath({parser.get().target().data(), parser.get().target().size()});
}

// Frames as the WebSocket reads them.
void Frames(const std::string& text) {
  boost::asio::io_context io;
  beast::test::stream wire(io), other(io);
  wire.connect(other);
  beast::websocket::stream<beast::test::stream> socket(std::move(wire));
  socket.read_message_max(1 << 14);
  boost::asio::write(other, boost::asio::buffer(std::string(
      "GET /ws HTTP/1.1\r\nHost: a\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
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

const std::filesystem::path& Folder() {
  static const std::filesystem::path folder = [] {
    std::string name = (std::filesystem::temp_directory_path() / "geond_fuzz_XXXXXX").string();
    return std::filesystem::path(mkdtemp(name.data()));
  }();
  return folder;
}

void Write(const std::filesystem::path& path, const std::string& text) { std::ofstream(path, std::ios::binary) << text; }

// What lies in a scan's folder after whatever has happened to it.
void Stored(const std::string& text) {
  const std::filesystem::path folder = Folder() / "scan";
  std::filesystem::create_directory(folder);
  const std::size_t half = text.find('\n');
  Write(folder / "journal.json", text.substr(0, half));
  Write(folder / "description.json", half == std::string::npos ? text : text.substr(half + 1));
  const ScanSummary scan = ReadSummary(folder, 1);
  Check(scan.state == ScanState::kDone || scan.state == ScanState::kFailed);
}

// An archive that somebody wants taken in.
void Archive(const std::string& text) {
  Write(Folder() / "archive.zip", text);
  try {
    ReadScanArchive(Folder() / "archive.zip", Folder() / "import", {1 << 20, 16});
  } catch (const FileError&) {
    Check(!std::filesystem::exists(Folder() / "import"));
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::string text(reinterpret_cast<const char*>(data) + 1, size - 1);
  switch (data[0] % 10) {
    case 0: {
      static const RpcTable table = Table();
      Client client;
      table.Handle(text, client, [](const std::string& answer) {
        const Json json = Json::parse(answer);  // throws if it is none
        Check(json.contains("result") != json.contains("error"));
      });
      break;
    }
    case 1: {
      const auto request = ParseRobotRequest(text);
      Check(!request || (request->number >= 0 && request->number <= 999 && text.size() <= kMaxRobotLine));
      break;
    }
    case 2:
      try {
        Check(ParseConfig(ConfigText(ParseConfig(text, "fuzz")), "again") == ParseConfig(text, "fuzz"));
      } catch (const ConfigError&) {
      }
      break;
    case 3:
      try {
        Check(EncodeExposure(DecodeExposure(text, "fuzz")) == text);
      } catch (const FileError&) {
      }
      break;
    case 4: {
      const auto range = ParseRange(text, 1000);
      Check(!range || range->first + range->length <= 1000);
      Check(!IsPlainPath(text) || text.find("..") != 0);
      IsLoopbackName(text);
      break;
    }
    case 5:
      Http(text);
      break;
    case 6:
      Frames(text);
      break;
    case 7:
      Stored(text);
      break;
    case 8:
      Archive(text);
      break;
    default:
      try {
        AllowList(text).Contains(text);
      } catch (const std::invalid_argument&) {
      }
  }
  return 0;
}
