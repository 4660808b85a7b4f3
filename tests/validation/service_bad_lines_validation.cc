// SPDX-License-Identifier: Apache-2.0
// A million lines that are wrong in every way, to a service that runs: each is answered, none is remembered.
// service_bad_lines_validation [LINES]. Prints memory before and after.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <future>
#include <random>
#include <thread>

#include <malloc.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include "daemon/server.h"
#include "daemon/service.h"
#include "tests/daemon/small_station.h"

namespace {

using namespace geond;
using namespace geond::daemon;

int Connect(int port) {
  const int fd = socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  return connect(fd, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0 ? fd : -1;
}

// A line that is no request, or a wrong one; never empty.
std::string BadLine(std::mt19937_64& random) {
  static const char* const kSeeds[] = {
      R"({"jsonrpc":"2.0","id":1,"method":"scan.status","params":{"scan":999}})",
      R"({"jsonrpc":"2.0","id":"x","method":"scan.start","params":{"views":"many"}})",
      R"({"jsonrpc":"2.0","id":2,"method":"object.describe","params":[1e99]})",
      R"({"jsonrpc":"1.0","id":3,"method":"station.status"})",
      R"([1,2,{"a":[[[[[[]]]]]]}])",
      R"({"jsonrpc":"2.0","id":4,"method":"auth.login","params":{"token":"0123456789abcdef"}})",
      "PART 999999",
      "GRASP -1",
      "GET / HTTP/1.1"};
  std::string line = kSeeds[random() % std::size(kSeeds)];
  for (std::uint64_t n = random() % 4; n > 0; --n) {
    const std::size_t at = random() % line.size();
    switch (random() % 3) {
      case 0:
        line[at] = static_cast<char>(random());
        break;
      case 1:
        line.erase(at, 1 + random() % 9);
        break;
      default:
        line.insert(at, 1 + random() % 9, static_cast<char>(random()));
    }
    if (line.empty()) line.push_back('?');
  }
  for (char& letter : line) {
    if (letter == '\n' || letter == '\r') letter = ' ';
  }
  return line + "\n";
}

// Sends `lines` of them in bursts and takes the answers in; how many came.
long Pester(int port, int lines, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const int fd = Connect(port);
  long answers = 0;
  std::thread reader([&] {
    char buffer[1 << 16];
    for (ssize_t n; (n = read(fd, buffer, sizeof buffer)) > 0;) {
      for (ssize_t i = 0; i < n; ++i) answers += buffer[i] == '\n';
    }
  });
  for (int sent = 0; sent < lines;) {
    std::string burst;
    for (; sent < lines && burst.size() < 8192; ++sent) {
      burst += BadLine(random);
    }
    for (std::size_t done = 0; done < burst.size();) {
      const ssize_t n = send(fd, burst.data() + done, burst.size() - done, MSG_NOSIGNAL);
      if (n <= 0) {
        std::printf("the connection was closed after %d lines\n", sent);
        sent = lines;
        break;
      }
      done += static_cast<std::size_t>(n);
    }
  }
  shutdown(fd, SHUT_WR);
  reader.join();
  close(fd);
  return answers;
}

// The same as robots speak: a few lines, then as many answers, one a line. How many came.
long Converse(int port, int lines, std::uint64_t seed) {
  constexpr int kAtOnce = 8;
  constexpr std::size_t kLongest = 70;
  std::mt19937_64 random(seed);
  const int fd = Connect(port);
  long answers = 0;
  for (int sent = 0; sent < lines; sent += kAtOnce) {
    std::string burst;
    for (int i = 0; i < kAtOnce; ++i) {
      std::string line = BadLine(random);
      if (line.size() > kLongest) line.erase(kLongest, line.size() - kLongest - 1);  // but for its end
      burst += line;
    }
    if (send(fd, burst.data(), burst.size(), MSG_NOSIGNAL) != static_cast<ssize_t>(burst.size())) break;
    char buffer[4096];
    for (int left = kAtOnce; left > 0;) {
      const ssize_t n = read(fd, buffer, sizeof buffer);
      if (n <= 0) {
        std::printf("the robot port closed after %d lines\n", sent);
        close(fd);
        return answers;
      }
      const auto ends = static_cast<int>(std::count(buffer, buffer + n, '\n'));
      left -= ends;
      answers += ends;
    }
  }
  close(fd);
  return answers;
}

// Once the station is idle: some of the lines begin scans, which take what they take while they run.
double Resident(Server& server) {
  const std::string name = "\nprocess_resident_memory_bytes ";
  for (;;) {
    std::promise<std::string> text;
    server.Post([&](Service& service) {
      malloc_trim(0);
      text.set_value(service.Metrics());
    });
    const std::string all = text.get_future().get();
    if (all.find("\ngeond_busy 0\n") == std::string::npos) continue;
    return std::stod(all.substr(all.find(name) + name.size())) / 1e6;
  }
}

}  // namespace

int main(int argc, char** argv) {
  const int lines = argc > 1 ? std::atoi(argv[1]) : 1000000;
  const TemporaryFolder folder;
  Config config;
  config.store_folder = (folder.path() / "store").string();
  config.api_unix_socket = "";
  config.api_port = config.robot_port = 0;
  config.http_port = -1;
  config.api_max_requests_per_s = 0;
  Server server(config, SmallStation(SmallWorld(16)));
  std::thread io([&] { server.Run(); });
  // The first tenth warms up what is kept for good.
  Pester(server.port(), lines / 10, 1);
  Converse(server.robot_port(), lines / 10, 2);
  const double before = Resident(server);
  long answers = 0;
  for (int i = 0; i < 10; ++i) answers += Pester(server.port(), lines / 10, 10 + static_cast<std::uint64_t>(i));
  const long robot = Converse(server.robot_port(), lines / 10, 3);
  const double after = Resident(server);
  std::printf("%d lines: %ld answers; %d to the robot port: %ld answers; memory %.2f MB, then %.2f MB\n", lines,
              answers, lines / 10, robot, before, after);
  server.Stop();
  io.join();
  return after - before < 1.0 ? 0 : 1;
}
