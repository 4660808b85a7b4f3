// SPDX-License-Identifier: Apache-2.0
#include "daemon/server.h"

#include <sstream>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include "core/base/error.h"
#include "daemon/command/command_line.h"
#include "daemon/command/service_client.h"
#include "daemon/service.h"
#include "tests/daemon/small_station.h"

namespace geond::daemon {
namespace {

using testing::HasSubstr;

// A server on a free port and a socket of its own, on a thread of its own.
class ServerTest : public testing::Test {
 protected:
  ServerTest() : world_(SmallWorld()) {
    config_.store_folder = (folder_.path() / "store").string();
    config_.api_unix_socket = (folder_.path() / "socket").string();
    config_.api_port = 0;
    config_.robot_port = 0;
    config_.http_port = 0;
    config_.api_max_clients = 4;
    config_.api_max_line_kb = 4;
    config_.api_max_unread_kb = 64;
    config_.scan_views = 4;
    config_.scan_triangles = 300;
    config_.scan_threads = 1;
    server_ = std::make_unique<Server>(config_, SmallStation(world_));
    thread_ = std::thread([this] { server_->Run(); });
  }
  ~ServerTest() override {
    server_->Stop();
    thread_.join();
  }

  std::string tcp() const { return "127.0.0.1:" + std::to_string(server_->port()); }

  // A bare TCP connection.
  int Connect() const {
    const int fd = socket(AF_INET, SOCK_STREAM, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    address.sin_port = htons(static_cast<std::uint16_t>(server_->port()));
    EXPECT_EQ(connect(fd, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
    return fd;
  }
  // All that comes until the other side closes.
  static std::string ReadToEnd(int fd) {
    std::string text;
    char buffer[4096];
    for (ssize_t n; (n = read(fd, buffer, sizeof buffer)) > 0;) text.append(buffer, static_cast<std::size_t>(n));
    close(fd);
    return text;
  }

  struct Outcome {
    int code;
    std::string out, err;
  };
  Outcome Geon(std::vector<std::string> arguments, std::stop_token stop = {}) const {
    std::ostringstream out, err;
    arguments.insert(arguments.begin() + 1, {"--socket", config_.api_unix_socket});
    const int code = RunGeon(arguments, stop, {out, err});
    return {code, out.str(), err.str()};
  }

  TemporaryFolder folder_;
  std::shared_ptr<sim::SimStation> world_;
  Config config_;
  std::unique_ptr<Server> server_;
  std::thread thread_;
};

TEST_F(ServerTest, GreetsAndAnswersOnBothSockets) {
  for (const std::string& address : {tcp(), config_.api_unix_socket}) {
    ServiceClient client(address);
    EXPECT_EQ(client.greeting()["params"]["service"], "geond");
    EXPECT_EQ(client.greeting()["params"]["protocol"], 1);
    EXPECT_EQ(client.Call("station.status")["state"], "idle");
    EXPECT_THROW(client.Call("nothing.there"), RpcError);
    EXPECT_EQ(client.Call("station.status")["state"], "idle");
  }
}

TEST_F(ServerTest, OneClientTooManyIsToldSo) {
  std::vector<std::unique_ptr<ServiceClient>> clients;
  for (int i = 0; i < 4; ++i) {
    clients.push_back(std::make_unique<ServiceClient>(tcp()));
    clients.back()->Call("station.status");
  }
  EXPECT_THAT(ReadToEnd(Connect()), HasSubstr("too_many_clients"));
  clients.pop_back();
  // The server learns of the end on its own thread; a client that asks until it is let in sees it.
  for (bool in = false; !in;) {
    ServiceClient client(tcp());
    in = client.greeting().value("method", "") == "greeting";
  }
}

TEST_F(ServerTest, ALineWithoutEndIsRefusedAndClosed) {
  const int fd = Connect();
  const std::string flood(16 << 10, 'x');
  EXPECT_GT(send(fd, flood.data(), flood.size(), MSG_NOSIGNAL), 0);
  EXPECT_THAT(ReadToEnd(fd), HasSubstr("too_large"));
  EXPECT_EQ(ServiceClient(tcp()).Call("station.status")["state"], "idle");
}

TEST_F(ServerTest, AClientThatDoesNotReadIsDroppedAndNobodyNotices) {
  const int slow = Connect();
  const std::string ask = R"({"jsonrpc":"2.0","id":1,"method":"rpc.discover"})" "\n";
  // It asks for ever more and reads nothing, until the server has had enough of it and the connection breaks.
  std::string many;
  for (int i = 0; i < 50; ++i) many += ask;
  while (send(slow, many.data(), many.size(), MSG_NOSIGNAL) > 0) {
  }
  close(slow);
  EXPECT_EQ(ServiceClient(tcp()).Call("station.status")["state"], "idle");
}

TEST_F(ServerTest, ASecondServerDoesNotTakeTheSocketAway) {
  Config second = config_;
  second.store_folder = (folder_.path() / "second").string();
  EXPECT_THROW(Server(second, SmallStation(SmallWorld(16))), ConfigError);
  EXPECT_EQ(ServiceClient(config_.api_unix_socket).Call("station.status")["state"], "idle");
}

TEST_F(ServerTest, APublicAddressIsRefused) {
  Config open = config_;
  open.api_address = "0.0.0.0";
  open.api_unix_socket = "";
  EXPECT_THROW(Server(open, SmallStation(SmallWorld(16))), ConfigError);
  open.api_address = "localhost.example";
  EXPECT_THROW(Server(open, SmallStation(SmallWorld(16))), ConfigError);
}

TEST_F(ServerTest, GeonScansAndListsOverTheSocket) {
  const Outcome scan = Geon({"scan", "--json", "--label", "egg"});
  ASSERT_EQ(scan.code, 0) << scan.err;
  EXPECT_EQ(Json::parse(scan.out)["n_parts"], 1);
  EXPECT_TRUE(scan.err.empty()) << scan.err;

  EXPECT_EQ(Json::parse(Geon({"scans", "--json"}).out)["scans"][0]["state"], "done");
  EXPECT_THAT(Geon({"scans"}).out, HasSubstr("ellipsoid"));
  EXPECT_THAT(Geon({"objects"}).out, HasSubstr("(egg)"));
  EXPECT_THAT(Geon({"objects", "1"}).out, HasSubstr("1 part"));
  EXPECT_THAT(Geon({"status"}).out, HasSubstr("laser off"));
  EXPECT_THAT(Geon({"api"}).out, HasSubstr("scan.start"));
  EXPECT_THAT(Geon({"api", "scan.status", R"({"scan":1})"}).out, HasSubstr("\"done\""));
  EXPECT_EQ(Json::parse(Geon({"home", "--json"}).out)["state"], "idle");
  EXPECT_EQ(Geon({"stop"}).code, 0);
  EXPECT_EQ(Geon({"doctor"}).code, 0);
  EXPECT_EQ(Geon({"cancel"}).code, 1);
  EXPECT_EQ(Geon({"objects", "7"}).code, 1);
}

TEST_F(ServerTest, GeonSaysWhatIsWrong) {
  world_->SetFault(sim::Device::kRangefinder, sim::Fault::kOff);
  const Outcome scan = Geon({"scan"});
  EXPECT_EQ(scan.code, 1);
  EXPECT_THAT(scan.err, HasSubstr("rangefinder"));
  EXPECT_TRUE(scan.out.empty());
  EXPECT_EQ(Geon({"doctor"}).code, 1);
}

TEST_F(ServerTest, GeonStoppedWhileItWaitsCancelsTheScan) {
  std::stop_source stop;
  server_->Post([&](Service&) { world_->Schedule(std::chrono::seconds(4), [&] { stop.request_stop(); }); });
  const Outcome scan = Geon({"scan", "--views", "300"}, stop.get_token());
  EXPECT_EQ(scan.code, 1);
  EXPECT_THAT(scan.err, HasSubstr("cancelled"));
  ServiceClient client(tcp());
  client.Call("events.subscribe");
  while (client.Call("station.status")["state"] != "idle") client.NextEvent();
  EXPECT_EQ(client.Call("scan.status")["state"], "cancelled");
  EXPECT_FALSE(world_->laser_emits());
}

TEST(ServiceClient, SaysWhereNobodyAnswers) {
  std::ostringstream out, err;
  EXPECT_EQ(RunGeon({"status", "--socket", "/nonexistent/socket"}, {}, {out, err}), 1);
  EXPECT_THAT(err.str(), HasSubstr("/nonexistent/socket"));
  EXPECT_EQ(RunGeon({"status", "--socket", "nonsense"}, {}, {out, err}), 1);
}

}  // namespace
}  // namespace geond::daemon
