// SPDX-License-Identifier: Apache-2.0
// Whole scans come and go over HTTP; where it listens the service says over its socket.
#include <utility>

#include <boost/asio.hpp>
#include <boost/beast.hpp>

#include <cstdlib>
#include <filesystem>

#include "core/base/error.h"
#include "core/base/printed.h"
#include "daemon/command/service_client.h"
#include "daemon/command/service_commands.h"

namespace geond::daemon {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;

constexpr auto kPatience = std::chrono::minutes(10);

struct Place {
  std::string host, port;
};

// Where the service listens for HTTP.
Place HttpPlace(ServiceClient& client) {
  const Json status = client.Call("station.status");
  const std::string url = status.value("http", "");
  constexpr std::string_view kPlain = "http://";
  if (url.empty()) throw DeviceError("geond", "find its HTTP port", "it has none", "Set http.port, and restart it");
  if (url.substr(0, kPlain.size()) != kPlain) {
    throw DeviceError("geond", "connect to " + url, "geon speaks no TLS",
                      "Fetch " + url + "/scans/NUMBER.zip with curl");
  }
  const std::size_t colon = url.rfind(':');
  Place place{url.substr(kPlain.size(), colon - kPlain.size()), url.substr(colon + 1)};
  if (place.host.front() == '[') place.host = place.host.substr(1, place.host.size() - 2);
  if (place.host == "0.0.0.0" || place.host == "::") place.host = "127.0.0.1";
  return place;
}

template <typename Body>
http::request<Body> Request(http::verb verb, const std::string& target) {
  http::request<Body> request(verb, target, 11);
  request.set(http::field::host, "localhost");
  request.set(http::field::user_agent, "geon");
  if (const char* token = std::getenv("GEOND_TOKEN"); token && *token) {
    request.set(http::field::authorization, std::string("Bearer ") + token);
  }
  return request;
}

[[noreturn]] void Refused(unsigned status, const std::string& body) {
  const Json answer = Json::parse(body, nullptr, false);
  if (answer.is_object() && answer.contains("error")) {
    const Json& error = answer["error"];
    throw RpcError(static_cast<RpcError::Code>(error.value("code", -32603)), error.value("message", ""),
                   error.contains("data") ? error["data"].value("remedy", "") : "");
  }
  throw DeviceError("geond", "answer", "HTTP status " + std::to_string(status) + ": " + body.substr(0, body.find('\n')),
                    status == 401 || status == 403 ? "Give a token of the role it needs (GEOND_TOKEN)" : "");
}

// One request, one response, over a connection of its own.
template <typename RequestBody, typename ResponseBody>
void Exchange(const Place& place, http::request<RequestBody>& request, http::response_parser<ResponseBody>& response) {
  asio::io_context io;
  asio::ip::tcp::resolver resolver(io);
  beast::tcp_stream stream(io);
  stream.expires_after(kPatience);
  try {
    stream.connect(resolver.resolve(place.host, place.port));
    request.prepare_payload();
    http::write(stream, request);
    beast::flat_buffer buffer;
    http::read(stream, buffer, response);
  } catch (const boost::system::system_error& error) {
    throw DeviceError("geond", "ask " + place.host + ":" + place.port, error.code().message(),
                      "See its log (journalctl -u geond)");
  }
}

}  // namespace

CommandResult Export(const ExportArguments& arguments, const CommandContext& context) {
  ServiceClient client(arguments.socket, context.stop);
  const Place place = HttpPlace(client);
  const Json made = client.Call("scan.export", {{"scan", arguments.scan}});
  const std::string output =
      arguments.output.empty() ? "scan_" + std::to_string(arguments.scan) + ".zip" : arguments.output;
  // Beside its place until it is whole.
  const std::string unfinished = output + ".part";
  http::response_parser<http::file_body> response;
  response.body_limit(std::uint64_t{1} << 40);
  boost::system::error_code error;
  response.get().body().open(unfinished.c_str(), beast::file_mode::write, error);
  if (error) throw FileError(unfinished, "write", error.message(), "Choose another place (-o)");
  auto request = Request<http::empty_body>(http::verb::get, made["path"].get<std::string>());
  Exchange(place, request, response);
  response.get().body().close();
  if (response.get().result() != http::status::ok) {
    std::filesystem::remove(unfinished);
    Refused(response.get().result_int(), "");
  }
  std::filesystem::rename(unfinished, output);
  return {{{"scan", arguments.scan}, {"file", output}, {"bytes", std::filesystem::file_size(output)}},
          Printed("scan %d is in %s", arguments.scan, output.c_str())};
}

CommandResult Import(const ImportArguments& arguments, const CommandContext& context) {
  ServiceClient client(arguments.socket, context.stop);
  const Place place = HttpPlace(client);
  auto request = Request<http::file_body>(http::verb::post, "/scans");
  request.set(http::field::content_type, "application/zip");
  boost::system::error_code error;
  request.body().open(arguments.file.c_str(), beast::file_mode::scan, error);
  if (error) throw FileError(arguments.file, "open", error.message(), "Check the path");
  http::response_parser<http::string_body> response;
  Exchange(place, request, response);
  if (response.get().result() != http::status::created) Refused(response.get().result_int(), response.get().body());
  Json scan = Json::parse(response.get().body());
  std::string text = Printed("it is scan %d", scan["scan"].get<int>());
  return {std::move(scan), std::move(text)};
}

CommandResult Pin(const PinArguments& arguments, const CommandContext& context) {
  ServiceClient client(arguments.socket, context.stop);
  Json result = client.Call("scan.pin", {{"scan", arguments.scan}, {"pinned", !arguments.off}});
  return {std::move(result),
          Printed(arguments.off ? "scan %d is pinned no longer" : "scan %d is pinned", arguments.scan)};
}

CommandResult Delete(const ScanNumberArguments& arguments, const CommandContext& context) {
  ServiceClient client(arguments.socket, context.stop);
  Json result = client.Call("scan.delete", {{"scan", arguments.scan}});
  return {std::move(result), Printed("scan %d is gone", arguments.scan)};
}

CommandResult LogLines(const LogArguments& arguments, const CommandContext& context) {
  Json result = ServiceClient(arguments.socket, context.stop).Call("log.tail", {{"limit", arguments.limit}});
  std::string text;
  for (const Json& line : result["lines"]) text += (text.empty() ? "" : "\n") + line.get<std::string>();
  return {std::move(result), std::move(text)};
}

}  // namespace geond::daemon
