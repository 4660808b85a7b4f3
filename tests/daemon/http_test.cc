// SPDX-License-Identifier: Apache-2.0
#include <fstream>
#include <sstream>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include "core/base/error.h"
#include "daemon/access_tokens.h"
#include "daemon/command/service_client.h"
#include "daemon/http_files.h"
#include "daemon/server.h"
#include "tests/daemon/small_station.h"

namespace geond::daemon {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

TEST(ParseRange, ReadsWhatBrowsersAsk) {
  EXPECT_EQ(ParseRange("bytes=0-9", 100)->length, 10u);
  EXPECT_EQ(ParseRange("bytes=90-", 100)->first, 90u);
  EXPECT_EQ(ParseRange("bytes=90-200", 100)->length, 10u);
  EXPECT_EQ(ParseRange("bytes=-30", 100)->first, 70u);
  EXPECT_EQ(ParseRange("bytes=-300", 100)->length, 100u);
  EXPECT_EQ(ParseRange("bytes=100-", 100)->length, 0u);
  EXPECT_EQ(ParseRange("bytes=-0", 100)->length, 0u);
  for (const char* wrong : {"", "bytes", "bytes=", "bytes=-", "bytes=5-2", "bytes=1-2,3-4", "bytes=a-b", "bytes=1-x", "lines=1-2",
                            "bytes=99999999999999999999-"}) {
    EXPECT_FALSE(ParseRange(wrong, 100)) << wrong;
  }
}

TEST(IsPlainPath, LetsNothingOut) {
  for (const char* fine : {"index.html", "a/b.js", "mesh.ply", "view_000.f32"}) EXPECT_TRUE(IsPlainPath(fine)) << fine;
  for (const char* wrong : {"", "../x", "a/../b", ".hidden", "a/.b", "/etc/passwd", "a//b", "a%2e", "a b", "a\\b"}) {
    EXPECT_FALSE(IsPlainPath(wrong)) << wrong;
  }
}

TEST(IsLoopbackName, KnowsThisMachine) {
  for (const char* own : {"localhost", "localhost:7180", "127.0.0.1:1", "[::1]:7180", "http://localhost:7180"}) {
    EXPECT_TRUE(IsLoopbackName(own)) << own;
  }
  for (const char* foreign : {"", "example.org", "http://example.org", "localhost.example.org", "127.0.0.1.example.org:80", "null",
                              "localhost:x", "[::1", "http://evil@localhost"}) {
    EXPECT_FALSE(IsLoopbackName(foreign)) << foreign;
  }
}

TEST(IsSameSite, ComparesOriginAndHost) {
  EXPECT_TRUE(IsSameSite("http://scanner.lab:7180", "scanner.lab:7180"));
  EXPECT_TRUE(IsSameSite("http://localhost:7180", "127.0.0.1:7180"));
  EXPECT_FALSE(IsSameSite("http://evil.example", "scanner.lab:7180"));
  EXPECT_FALSE(IsSameSite("null", "scanner.lab:7180"));
  EXPECT_FALSE(IsSameSite("", ""));
}

class HttpTest : public testing::Test {
 protected:
  explicit HttpTest(const std::string& tokens = "") : world_(SmallWorld()) {
    Config config;
    config.api_tokens = tokens.empty() ? "" : (folder_.path() / "tokens").string();
    std::ofstream(folder_.path() / "tokens") << tokens;
    std::filesystem::permissions(folder_.path() / "tokens", std::filesystem::perms(0600));
    config.store_folder = (folder_.path() / "store").string();
    config.api_unix_socket = (folder_.path() / "socket").string();
    config.api_port = config.http_port = config.robot_port = 0;
    config.scan_views = 4;
    config.scan_triangles = 300;
    config.scan_threads = 1;
    config.http_page = (folder_.path() / "page").string();
    std::filesystem::create_directory(config.http_page);
    std::ofstream(folder_.path() / "page/index.html") << "<p>hello</p>";
    socket_ = config.api_unix_socket;
    server_ = std::make_unique<Server>(config, SmallStation(world_));
    thread_ = std::thread([this] { server_->Run(); });
  }
  ~HttpTest() override {
    server_->Stop();
    thread_.join();
  }

  int Connect(int port) const {
    const int fd = socket(AF_INET, SOCK_STREAM, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    address.sin_port = htons(static_cast<std::uint16_t>(port));
    EXPECT_EQ(connect(fd, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
    return fd;
  }
  // The whole response to a request whose connection ends with it.
  std::string Ask(const std::string& head, const std::string& body = "") const {
    const int fd = Connect(server_->http_port());
    std::string request = head + "\r\nConnection: close\r\n";
    if (head.find("Host:") == std::string::npos) request += "Host: localhost\r\n";
    if (!body.empty()) request += "Content-Length: " + std::to_string(body.size()) + "\r\n";
    request += "\r\n" + body;
    EXPECT_EQ(send(fd, request.data(), request.size(), MSG_NOSIGNAL), static_cast<ssize_t>(request.size()));
    std::string text;
    char buffer[4096];
    for (ssize_t n; (n = read(fd, buffer, sizeof buffer)) > 0;) text.append(buffer, static_cast<std::size_t>(n));
    close(fd);
    return text;
  }
  void ScanToEnd() {
    ServiceClient client(socket_);
    client.Call("events.subscribe");
    client.Call("scan.start");
    while (true) {
      const Json event = client.NextEvent();
      if (event["event"] == "scan" && event["state"] == "done") return;
      ASSERT_FALSE(event["event"] == "scan" && event["state"] == "failed") << event.dump();
    }
  }
  // One line to the robot port, one line from it.
  std::string Robot(int fd, const std::string& line, const char* end = "\n") const {
    const std::string sent = line + end;
    EXPECT_EQ(send(fd, sent.data(), sent.size(), MSG_NOSIGNAL), static_cast<ssize_t>(sent.size()));
    std::string got;
    for (char letter; read(fd, &letter, 1) == 1 && letter != '\n';) got += letter;
    return got;
  }

  TemporaryFolder folder_;
  std::shared_ptr<sim::SimStation> world_;
  std::string socket_;
  std::unique_ptr<Server> server_;
  std::thread thread_;
};

// The same with tokens.
class GuardedTest : public HttpTest {
 protected:
  GuardedTest() : HttpTest("read reader-0123456789\nscan scanner-0123456789 # a robot cell\n") {}
};

TEST_F(GuardedTest, EachMayDoWhatItsTokenAllows) {
  ServiceClient over_tcp("127.0.0.1:" + std::to_string(server_->port()));
  EXPECT_THROW(over_tcp.Call("station.status"), RpcError);
  EXPECT_THROW(over_tcp.Call("auth.login", {{"token", "reader-012345678X"}}), RpcError);
  EXPECT_EQ(over_tcp.Call("auth.login", {{"token", "reader-0123456789"}})["role"], "read");
  EXPECT_EQ(over_tcp.Call("station.status")["state"], "idle");
  EXPECT_THROW(over_tcp.Call("station.home"), RpcError);
  EXPECT_EQ(over_tcp.Call("auth.login", {{"token", "scanner-0123456789"}})["role"], "scan");
  EXPECT_EQ(over_tcp.Call("station.home")["state"], "idle");
  EXPECT_EQ(ServiceClient(socket_).Call("station.status")["state"], "idle") << "the Unix socket is guarded by its mode";

  const std::string call = R"({"jsonrpc":"2.0","id":5,"method":"station.status"})";
  const std::string post = "POST /rpc HTTP/1.1\r\nContent-Type: application/json\r\nHost: scanner.lab";
  EXPECT_THAT(Ask(post, call), HasSubstr("forbidden"));
  EXPECT_THAT(Ask(post + "\r\nAuthorization: Bearer reader-0123456789", call), HasSubstr("idle"));
  EXPECT_THAT(Ask("GET /metrics HTTP/1.1"), StartsWith("HTTP/1.1 401"));
  EXPECT_THAT(Ask("GET /scans/1/mesh.ply HTTP/1.1"), StartsWith("HTTP/1.1 401"));
  EXPECT_THAT(Ask("GET /scans/1.zip HTTP/1.1"), StartsWith("HTTP/1.1 401"));
  EXPECT_THAT(Ask("POST /scans HTTP/1.1\r\nAuthorization: Bearer scanner-0123456789", "x"), StartsWith("HTTP/1.1 403"));
  EXPECT_THAT(Ask("GET / HTTP/1.1"), StartsWith("HTTP/1.1 200"));
}

TEST_F(GuardedTest, GuessingIsNotWorthWhile) {
  ServiceClient client("127.0.0.1:" + std::to_string(server_->port()));
  for (int i = 0; i < 5; ++i) EXPECT_THROW(client.Call("auth.login", {{"token", "guess-" + std::to_string(1000000000 + i)}}), RpcError);
  EXPECT_THROW(client.Call("auth.login", {{"token", "scanner-0123456789"}}), RpcError);
}

TEST(AccessTokens, MistakesAreFatalAndNamed) {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder.path() / "tokens";
  const auto write = [&](const std::string& text, int mode) {
    std::ofstream(path) << text;
    std::filesystem::permissions(path, std::filesystem::perms(mode));
  };
  for (const char* wrong : {"", "# nothing\n", "read\n", "read short\n", "root 0123456789abcdef\n", "read 0123456789abcdef more\n"}) {
    write(wrong, 0600);
    EXPECT_THROW(AccessTokens{path}, ConfigError) << wrong;
  }
  write("admin 0123456789abcdef\n", 0644);
  EXPECT_THROW(AccessTokens{path}, FileError);
  EXPECT_THROW(AccessTokens{folder.path() / "absent"}, FileError);
  write("admin 0123456789abcdef\n", 0640);
  EXPECT_EQ(AccessTokens(path).RoleOf("0123456789abcdef"), Role::kAdmin);
  EXPECT_EQ(AccessTokens(path).RoleOf("0123456789abcdeg"), Role::kNone);
  EXPECT_EQ(AccessTokens(path).RoleOf(""), Role::kNone);
  EXPECT_EQ(AccessTokens(path).RoleOf("0123456789abcdef0123456789abcdef"), Role::kNone);
}

TEST_F(HttpTest, AnswersMethodsAndServesThePage) {
  const std::string call = R"({"jsonrpc":"2.0","id":5,"method":"station.status"})";
  const std::string post = "POST /rpc HTTP/1.1\r\nContent-Type: application/json";
  const std::string answer = Ask(post, call);
  EXPECT_THAT(answer, StartsWith("HTTP/1.1 200"));
  EXPECT_THAT(answer, HasSubstr("\"id\":5"));
  EXPECT_THAT(answer, HasSubstr("\"idle\""));
  EXPECT_THAT(Ask(post, R"({"jsonrpc":"2.0","id":6,"method":"station.home"})"), HasSubstr("\"id\":6"));
  EXPECT_THAT(Ask(post, R"({"jsonrpc":"2.0","id":7,"method":"events.subscribe"})"), HasSubstr("unavailable"));
  EXPECT_THAT(Ask("POST /rpc HTTP/1.1\r\nContent-Type: text/plain", call), StartsWith("HTTP/1.1 400"));
  EXPECT_THAT(Ask("GET / HTTP/1.1"), HasSubstr("<p>hello</p>"));
  EXPECT_THAT(Ask("GET /../socket HTTP/1.1"), StartsWith("HTTP/1.1 404"));
  EXPECT_THAT(Ask("GET /absent.js HTTP/1.1"), StartsWith("HTTP/1.1 404"));
  EXPECT_THAT(Ask("DELETE / HTTP/1.1"), StartsWith("HTTP/1.1 405"));
  EXPECT_THAT(Ask("GET /metrics HTTP/1.1"), HasSubstr("geond_scans_ended_total{state=\"done\"} 0"));
}

TEST_F(HttpTest, RefusesPagesFromElsewhere) {
  EXPECT_THAT(Ask("GET / HTTP/1.1\r\nHost: evil.example"), StartsWith("HTTP/1.1 403"));
  EXPECT_THAT(Ask("POST /rpc HTTP/1.1\r\nContent-Type: application/json\r\nOrigin: http://evil.example", "{}"), StartsWith("HTTP/1.1 403"));
  EXPECT_THAT(Ask("GET / HTTP/1.1\r\nOrigin: http://localhost:7180"), StartsWith("HTTP/1.1 200"));
}

TEST_F(HttpTest, ServesFilesOfDoneScansByRangeAndTag) {
  EXPECT_THAT(Ask("GET /scans/1/mesh.ply HTTP/1.1"), StartsWith("HTTP/1.1 404"));
  ScanToEnd();
  const std::string whole = Ask("GET /scans/1/mesh.ply HTTP/1.1");
  EXPECT_THAT(whole, StartsWith("HTTP/1.1 200"));
  EXPECT_THAT(whole, HasSubstr("\r\n\r\nply\n"));
  const std::size_t at = whole.find("ETag: ") + 6;
  const std::string tag = whole.substr(at, whole.find("\r\n", at) - at);
  EXPECT_THAT(Ask("GET /scans/1/mesh.ply HTTP/1.1\r\nIf-None-Match: " + tag), StartsWith("HTTP/1.1 304"));
  const std::string part = Ask("GET /scans/1/mesh.ply HTTP/1.1\r\nRange: bytes=0-2");
  EXPECT_THAT(part, StartsWith("HTTP/1.1 206"));
  EXPECT_EQ(part.substr(part.size() - 3), "ply");
  EXPECT_THAT(Ask("GET /scans/1/mesh.ply HTTP/1.1\r\nRange: bytes=99999999-"), StartsWith("HTTP/1.1 416"));
  EXPECT_THAT(Ask("GET /scans/1/../1/mesh.ply HTTP/1.1"), StartsWith("HTTP/1.1 404"));
  EXPECT_THAT(Ask("GET /scans/1x/mesh.ply HTTP/1.1"), StartsWith("HTTP/1.1 404"));
  EXPECT_THAT(Ask("GET /metrics HTTP/1.1"), HasSubstr("geond_scans_ended_total{state=\"done\"} 1"));
}

TEST_F(HttpTest, HandsOutWholeScansAndTakesThemIn) {
  EXPECT_THAT(Ask("GET /scans/1.zip HTTP/1.1"), StartsWith("HTTP/1.1 404"));
  ScanToEnd();
  const std::string answer = Ask("GET /scans/1.zip HTTP/1.1");
  ASSERT_THAT(answer, StartsWith("HTTP/1.1 200"));
  const std::string archive = answer.substr(answer.find("\r\n\r\n") + 4);
  EXPECT_EQ(archive.substr(0, 2), "PK");
  EXPECT_THAT(Ask("HEAD /scans/1.zip HTTP/1.1"), HasSubstr("Content-Length: " + std::to_string(archive.size())));

  const std::string post = "POST /scans HTTP/1.1\r\nContent-Type: application/zip";
  const std::string taken = Ask(post, archive);
  EXPECT_THAT(taken, StartsWith("HTTP/1.1 201"));
  EXPECT_THAT(taken, HasSubstr("\"scan\":2,\"state\":\"done\""));
  ServiceClient client(socket_);
  Json original = client.Call("object.describe", {{"scan", 1}}), copy = client.Call("object.describe", {{"scan", 2}});
  EXPECT_EQ(copy["parts"], original["parts"]);
  EXPECT_EQ(client.Call("scan.export", {{"scan", 2}})["path"], "/scans/2.zip");

  EXPECT_THAT(Ask(post, archive.substr(0, archive.size() / 2)), StartsWith("HTTP/1.1 422"));
  EXPECT_THAT(Ask(post, "nonsense"), HasSubstr("\"storage\""));
  EXPECT_THAT(Ask(post + "\r\nOrigin: http://evil.example", archive), StartsWith("HTTP/1.1 403"));
  EXPECT_EQ(client.Call("scan.list")["scans"].size(), 2u);
  EXPECT_TRUE(std::filesystem::is_empty(folder_.path() / "store/import")) << "what came in is not left behind";
}

TEST_F(HttpTest, RefusesWhatIsTooLargeBeforeReadingIt) {
  const std::string post = "POST /rpc HTTP/1.1\r\nContent-Type: application/json\r\nContent-Length: ";
  EXPECT_THAT(Ask(post + "900000000"), StartsWith("HTTP/1.1 413"));
  EXPECT_THAT(Ask(post + "9000000000"), StartsWith("HTTP/1.1 413"));
  EXPECT_THAT(Ask("GET / HTTP/1.1\r\nX-Long: " + std::string(20000, 'x')), StartsWith("HTTP/1.1 413"));
}

TEST_F(HttpTest, ANotificationIsAnsweredWithNothing) {
  const std::string post = "POST /rpc HTTP/1.1\r\nContent-Type: application/json";
  EXPECT_THAT(Ask(post, R"({"jsonrpc":"2.0","method":"station.status"})"), StartsWith("HTTP/1.1 204"));
}

TEST_F(HttpTest, EndsWhileAWebSocketIsOpen) {
  const int fd = Connect(server_->http_port());  // open until the program ends, so that the server ends first
  const std::string request =
      "GET /ws HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
      "Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\nSec-WebSocket-Version: 13\r\n\r\n";
  ASSERT_EQ(send(fd, request.data(), request.size(), MSG_NOSIGNAL), static_cast<ssize_t>(request.size()));
  std::string text;
  for (char letter; text.find("greeting") == std::string::npos && read(fd, &letter, 1) == 1;) text += letter;
  EXPECT_THAT(text, StartsWith("HTTP/1.1 101"));
  EXPECT_THAT(text, HasSubstr("greeting"));
}

TEST_F(HttpTest, RobotsAskOnTheirOwnPort) {
  const int fd = Connect(server_->robot_port());
  EXPECT_THAT(Robot(fd, "STATUS"), StartsWith("2 "));
  EXPECT_THAT(Robot(fd, "OBJECT"), StartsWith("2 "));
  EXPECT_THAT(Robot(fd, "DANCE"), StartsWith("6 "));
  EXPECT_THAT(Robot(fd, "SCAN", "\r\n"), StartsWith("0 "));
  ServiceClient client(socket_);
  client.Call("events.subscribe");
  while (client.Call("station.status")["state"] != "idle") client.NextEvent();
  EXPECT_THAT(Robot(fd, "STATUS", "\r"), StartsWith("0 0 1 "));
  EXPECT_THAT(Robot(fd, "part 1"), StartsWith("0 1 0 "));
  EXPECT_THAT(Robot(fd, "PART 2"), StartsWith("3 "));
  EXPECT_THAT(Robot(fd, "GRASP 1"), StartsWith("0 "));
  EXPECT_THAT(Robot(fd, "DIALECT UR"), StartsWith("(0,0,0,"));
  EXPECT_THAT(Robot(fd, "PART 1"), StartsWith("(0,1,0,"));
  EXPECT_THAT(Robot(fd, "DIALECT ABB"), StartsWith("[0,"));
  EXPECT_THAT(Robot(fd, "POSE 1"), StartsWith("[["));
  EXPECT_THAT(Robot(fd, "STOP"), StartsWith("[0,"));
  EXPECT_THAT(Robot(fd, std::string(100, 'x')), StartsWith("[6,"));
  close(fd);
}

}  // namespace
}  // namespace geond::daemon
