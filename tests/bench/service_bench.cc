// SPDX-License-Identifier: Apache-2.0
// How many object.describe the service answers, and how soon, at 64 clients with one question each under way, in memory of
// one process, first with the station idle, then while it scans; and whether the scan misses anything for it:
// service_bench [clients [questions a client [views of the scans]]]. Prints; asserts nothing of time.
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <thread>
#include <vector>

#include <netinet/in.h>
#include <sys/socket.h>

#include "daemon/command/service_client.h"
#include "daemon/server.h"
#include "tests/daemon/small_station.h"

namespace {

using namespace geond;
using namespace geond::daemon;
using Clock = std::chrono::steady_clock;

// Asks `questions` times over a bare socket; the seconds each answer took.
std::vector<double> Ask(int port, int questions, std::size_t& bytes) {
  const int fd = socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  std::vector<double> seconds;
  if (connect(fd, reinterpret_cast<sockaddr*>(&address), sizeof address) != 0) return seconds;
  char buffer[1 << 16];
  const auto read_line = [&] {
    for (ssize_t n; (n = read(fd, buffer, sizeof buffer)) > 0;) {
      bytes += static_cast<std::size_t>(n);
      if (buffer[n - 1] == '\n') return true;
    }
    return false;
  };
  read_line();  // the greeting
  const std::string question = R"({"jsonrpc":"2.0","id":1,"method":"object.describe"})" "\n";
  for (int i = 0; i < questions; ++i) {
    const auto start = Clock::now();
    if (send(fd, question.data(), question.size(), MSG_NOSIGNAL) < 0 || !read_line()) break;
    seconds.push_back(std::chrono::duration<double>(Clock::now() - start).count());
  }
  close(fd);
  return seconds;
}

// All clients at once; whether every question was answered.
bool AskAll(int port, int clients, int questions, const char* what) {
  std::vector<std::vector<double>> all(static_cast<std::size_t>(clients));
  std::vector<std::size_t> bytes(all.size());
  const auto start = Clock::now();
  const std::clock_t cpu = std::clock();
  {
    std::vector<std::jthread> threads;
    for (std::size_t i = 0; i < all.size(); ++i) threads.emplace_back([&, i] { all[i] = Ask(port, questions, bytes[i]); });
  }
  const double wall = std::chrono::duration<double>(Clock::now() - start).count();
  const double cpu_seconds = static_cast<double>(std::clock() - cpu) / CLOCKS_PER_SEC;
  std::vector<double> seconds;
  std::size_t total = 0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    seconds.insert(seconds.end(), all[i].begin(), all[i].end());
    total += bytes[i];
  }
  if (seconds.empty()) return false;
  std::sort(seconds.begin(), seconds.end());
  std::printf("%s: %zu answers of %zu bytes at %d clients: %.0f a second, median %.1f ms, p99 %.1f ms, %.0f us of CPU each\n", what,
              seconds.size(), total / seconds.size(), clients, static_cast<double>(seconds.size()) / wall,
              1e3 * seconds[seconds.size() / 2], 1e3 * seconds[seconds.size() * 99 / 100],
              1e6 * cpu_seconds / static_cast<double>(seconds.size()));
  return seconds.size() == all.size() * static_cast<std::size_t>(questions);
}

// Scan after scan until told otherwise; the views that were told of, of those asked for.
struct Sampling {
  int scans = 0, views = 0, wanted = 0;
  bool in_order = true;
};
Sampling ScanOn(const std::string& socket, int views, const std::atomic<bool>& enough) {
  Sampling sampling;
  ServiceClient client(socket);
  client.Call("events.subscribe");
  do {
    const int scan = client.Call("scan.start", {{"views", views}})["scan"].get<int>();
    sampling.wanted += views;
    int next = 0;
    for (Json event; event["event"] != "scan" || event["scan"] != scan || event["state"] == "running";) {
      event = client.NextEvent();
      if (event["event"] == "view" && event["scan"] == scan) sampling.in_order &= event["view"] == next++;
    }
    sampling.views += next;
    ++sampling.scans;
  } while (!enough);
  return sampling;
}

}  // namespace

int main(int argc, char** argv) {
  const int clients = argc > 1 ? std::atoi(argv[1]) : 64, questions = argc > 2 ? std::atoi(argv[2]) : 500;
  const int views = argc > 3 ? std::atoi(argv[3]) : 12;
  const TemporaryFolder folder;
  Config config;
  config.store_folder = (folder.path() / "store").string();
  config.api_unix_socket = (folder.path() / "socket").string();
  config.api_port = 0;
  config.robot_port = config.http_port = -1;
  config.scan_views = 4;
  config.scan_triangles = 300;
  config.api_max_requests_per_s = 0;
  Server server(config, SmallStation(SmallWorld()));
  std::thread io([&] { server.Run(); });
  {
    ServiceClient client(config.api_unix_socket);
    client.Call("events.subscribe");
    client.Call("scan.start");
    for (Json event; event["event"] != "scan" || event["state"] == "running";) event = client.NextEvent();
  }
  bool all = AskAll(server.port(), clients, questions, "idle");
  std::atomic<bool> enough = false;
  Sampling sampling;
  std::jthread scanning([&] { sampling = ScanOn(config.api_unix_socket, views, enough); });
  all &= AskAll(server.port(), clients, questions, "scanning");
  enough = true;
  scanning.join();
  std::printf("meanwhile %d scans, %d of %d views kept and told of, %s\n", sampling.scans, sampling.views, sampling.wanted,
              sampling.in_order ? "in order" : "OUT OF ORDER");
  server.Stop();
  io.join();
  return all && sampling.in_order && sampling.views == sampling.wanted ? 0 : 1;
}
