// SPDX-License-Identifier: Apache-2.0
// Whatever a browser sends: what the HTTP port reads of it and asks of that, each alone too.
#include <utility>

#include <boost/asio.hpp>
#include <boost/beast.hpp>

#include <cstdint>
#include <string>

#include "daemon/http_files.h"
#include "tests/fuzz/check.h"

namespace {

using namespace geond::daemon;
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

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  Http(text);
  const auto range = ParseRange(text, 1000);
  Check(!range || range->first + range->length <= 1000);
  Check(!IsPlainPath(text) || text.find("..") != 0);
  IsLoopbackName(text);
  return 0;
}
