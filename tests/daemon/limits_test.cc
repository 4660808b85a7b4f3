// SPDX-License-Identifier: Apache-2.0
// What one client may take, and that the others do not notice.
#include <future>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include "daemon/command/service_client.h"
#include "daemon/rate_limit.h"
#include "daemon/server.h"
#include "daemon/service.h"
#include "tests/daemon/small_station.h"

namespace geond::daemon {
namespace {

using testing::HasSubstr;

class LimitsTest : public testing::Test {
 protected:
  void Open(const std::function<void(Config&)>& change = {}) {
    config_.store_folder = (folder_.path() / "store").string();
    config_.api_unix_socket = (folder_.path() / "socket").string();
    config_.api_port = config_.http_port = 0;
    config_.robot_port = -1;
    if (change) change(config_);
    server_ = std::make_unique<Server>(config_, SmallStation(SmallWorld(16)));
    thread_ = std::thread([this] { server_->Run(); });
  }
  ~LimitsTest() override {
    for (const int fd : open_) close(fd);
    server_->Stop();
    thread_.join();
  }

  int Connect(int port) {
    const int fd = socket(AF_INET, SOCK_STREAM, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    address.sin_port = htons(static_cast<std::uint16_t>(port));
    EXPECT_EQ(connect(fd, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
    open_.push_back(fd);
    return fd;
  }
  static std::string ReadLine(int fd) {
    std::string line;
    for (char letter; read(fd, &letter, 1) == 1 && letter != '\n';) line += letter;
    return line;
  }
  static std::string ReadToEnd(int fd) {
    std::string text;
    char buffer[4096];
    for (ssize_t n; (n = read(fd, buffer, sizeof buffer)) > 0;) text.append(buffer, static_cast<std::size_t>(n));
    return text;
  }
  static bool Say(int fd, const std::string& text) {
    return send(fd, text.data(), text.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(text.size());
  }
  double Metric(const std::string& name) {
    std::promise<std::string> text;
    server_->Post([&](Service& service) { text.set_value(service.Metrics()); });
    const std::string all = text.get_future().get();
    const std::size_t at = all.find("\n" + name + " ");
    return at == std::string::npos ? -1.0 : std::stod(all.substr(at + name.size() + 2));
  }

  TemporaryFolder folder_;
  Config config_;
  std::unique_ptr<Server> server_;
  std::thread thread_;
  std::vector<int> open_;
};

constexpr char kStatus[] = R"({"jsonrpc":"2.0","id":1,"method":"station.status"})"
                           "\n";

TEST_F(LimitsTest, The257thClientIsToldThatThereAre256) {
  Open();
  std::vector<int> clients;
  for (int i = 0; i < 256; ++i) {
    clients.push_back(Connect(server_->port()));
    ASSERT_THAT(ReadLine(clients.back()), HasSubstr("greeting")) << i;
  }
  const std::string refusal = ReadToEnd(Connect(server_->port()));
  EXPECT_THAT(refusal, HasSubstr("too_many_clients"));
  EXPECT_THAT(refusal, HasSubstr("there are 256 clients already"));
  for (const int client : clients) ASSERT_TRUE(Say(client, kStatus));
  for (const int client : clients) ASSERT_THAT(ReadLine(client), HasSubstr("\"idle\""));
  EXPECT_EQ(Metric("geond_refused_total{why=\"too_many_clients\"}"), 1.0);
  EXPECT_EQ(Metric("geond_clients"), 256.0);
}

TEST_F(LimitsTest, OverHttpTooOneClientTooManyIsToldSo) {
  Open([](Config& config) { config.api_max_clients = 3; });
  std::vector<int> clients;
  for (int i = 0; i < 3; ++i) {
    clients.push_back(Connect(server_->http_port()));
    ASSERT_TRUE(Say(clients.back(), "GET /nothing HTTP/1.1\r\nHost: localhost\r\n\r\n"));
    ASSERT_THAT(ReadLine(clients.back()), HasSubstr("404"));  // it stays open for the next request
  }
  const std::string refusal = ReadToEnd(Connect(server_->http_port()));
  EXPECT_THAT(refusal, HasSubstr("HTTP/1.1 503"));
  EXPECT_THAT(refusal, HasSubstr("too_many_clients"));
}

// What a client that reads nothing may cost, bytes; AddressSanitizer keeps what is freed (256 MB) and pads all blocks.
#ifdef __SANITIZE_ADDRESS__
constexpr double kMostGrowth = 512e6;
#else
constexpr double kMostGrowth = 64e6;
#endif

TEST_F(LimitsTest, AClientThatReadsNothingIsDroppedAtItsLimitAndNobodyElseNotices) {
  Open([](Config& config) { config.api_max_requests_per_s = 0; });
  ServiceClient reader(config_.api_unix_socket);
  const double before = Metric("process_resident_memory_bytes");
  const int slow = Connect(server_->port());
  std::string many;
  for (int i = 0; i < 50; ++i)
    many += R"({"jsonrpc":"2.0","id":1,"method":"rpc.discover"})"
            "\n";
  int asked = 0;
  while (send(slow, many.data(), many.size(), MSG_NOSIGNAL) > 0) {
    if (++asked % 4 == 0) {
      EXPECT_EQ(reader.Call("station.status")["state"], "idle");
    }
  }
  while (Metric("geond_refused_total{why=\"slow_reader\"}") != 1.0) {
  }
  EXPECT_LT(Metric("process_resident_memory_bytes") - before, kMostGrowth);
  EXPECT_EQ(reader.Call("station.status")["clients"], 1);
}

TEST_F(LimitsTest, AClientThatAsksTooOftenIsToldSoAndOthersAreAnswered) {
  Open([](Config& config) { config.api_max_requests_per_s = 10; });
  const int hasty = Connect(server_->port());
  ReadLine(hasty);
  std::string many;
  for (int i = 0; i < 100; ++i) many += kStatus;
  ASSERT_TRUE(Say(hasty, many));
  int answered = 0, refused = 0;
  for (int i = 0; i < 100; ++i) {
    const Json answer = Json::parse(ReadLine(hasty));
    EXPECT_EQ(answer["id"], 1);
    if (answer.contains("result")) ++answered;
    if (answer.contains("error") && answer["error"]["data"]["name"] == "rate_limited") ++refused;
  }
  EXPECT_EQ(answered + refused, 100);
  EXPECT_GE(answered, 20);
  EXPECT_GE(refused, 10);
  EXPECT_EQ(ServiceClient(config_.api_unix_socket).Call("station.status")["state"], "idle");
}

TEST(RateLimit, LetsSoManyThingsASecondAndTwiceAsManyAfterARest) {
  const RateLimit::Time start{};
  const auto at = [&](double seconds) {
    return start + std::chrono::duration_cast<RateLimit::Time::duration>(std::chrono::duration<double>(seconds));
  };
  RateLimit limit;
  int allowed = 0;
  for (int i = 0; i < 100; ++i) allowed += limit.Allows(10, at(0));
  EXPECT_EQ(allowed, 20);
  allowed = 0;
  for (int i = 0; i < 1000; ++i) allowed += limit.Allows(10, at(0.01 * i));  // ten seconds
  EXPECT_NEAR(allowed, 100, 1);
  allowed = 0;
  for (int i = 0; i < 100; ++i) allowed += limit.Allows(10, at(1000));
  EXPECT_EQ(allowed, 20);
  for (int i = 0; i < 1000; ++i) EXPECT_TRUE(limit.Allows(0, at(1000)));
}

}  // namespace
}  // namespace geond::daemon
