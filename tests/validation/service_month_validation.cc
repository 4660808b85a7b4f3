// SPDX-License-Identifier: Apache-2.0
// Thirty days of a station in simulated time: scans one after the other through the whole service, store and sockets,
// with retention, faults, stops and clients that come and go; what memory, descriptors and disk do meanwhile.
// service_month_validation [SCANS [DAYS]]. Prints a line every tenth; the slope of memory is that of a line through the
// last three quarters of them.
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <future>
#include <thread>
#include <vector>

#include <malloc.h>

#include "daemon/command/service_client.h"
#include "daemon/server.h"
#include "daemon/service.h"
#include "tests/daemon/small_station.h"

namespace {

using namespace geond;
using namespace geond::daemon;

double Metric(Server& server, const std::string& name) {
  std::promise<std::string> text;
  server.Post([&](Service& service) { text.set_value(service.Metrics()); });
  const std::string all = text.get_future().get();
  const std::size_t at = all.find("\n" + name + " ");
  return at == std::string::npos ? 0.0 : std::stod(all.substr(at + name.size() + 2));
}

// Least squares slope of y over x.
double Slope(const std::vector<double>& x, const std::vector<double>& y) {
  double mx = 0, my = 0, xx = 0, xy = 0;
  const auto n = static_cast<double>(x.size());
  for (std::size_t i = 0; i < x.size(); ++i) {
    mx += x[i] / n;
    my += y[i] / n;
  }
  for (std::size_t i = 0; i < x.size(); ++i) {
    xx += (x[i] - mx) * (x[i] - mx);
    xy += (x[i] - mx) * (y[i] - my);
  }
  return xy / xx;
}

}  // namespace

int main(int argc, char** argv) {
  const int scans = argc > 1 ? std::atoi(argv[1]) : 10000, days = argc > 2 ? std::atoi(argv[2]) : 30;
  const TemporaryFolder folder;
  const auto world = SmallWorld(24);
  Config config;
  config.store_folder = (folder.path() / "store").string();
  config.api_unix_socket = (folder.path() / "socket").string();
  config.api_port = 0;
  config.robot_port = config.http_port = -1;
  config.scan_views = 3;
  config.scan_triangles = 120;
  config.scan_picture = false;
  config.scan_threads = 1;
  config.store_max_size_gb = 0.01;
  Server server(config, SmallStation(world));
  std::thread io([&] { server.Run(); });
  int done = 0, failed = 0;
  std::vector<double> at, memory, descriptors;
  std::printf("%8s %10s %8s %12s %12s %10s %10s\n", "scans", "sim. days", "CPU s", "memory MB", "descriptors", "stored",
              "store MB");
  const auto start_wall = std::chrono::system_clock::now();
  const auto start_steady = std::chrono::steady_clock::now();
  const auto gap = std::chrono::duration<double>(86400.0 * days / scans);
  {
    auto client = std::make_unique<ServiceClient>(config.api_unix_socket);
    client->Call("events.subscribe");
    for (int i = 1; i <= scans; ++i) {
      if (i % 50 == 0) {  // clients do not stay for a month
        client = std::make_unique<ServiceClient>(config.api_unix_socket);
        client->Call("events.subscribe");
      }
      const bool fault = i % 97 == 0, stopped = i % 89 == 0;
      if (fault) client->Call("simulation.fault", {{"device", "rangefinder"}, {"fault", "stuck"}});
      client->Call("scan.start");
      if (stopped) client->Call("station.stop");
      Json event;
      while (event["event"] != "scan" || event["state"] == "running" || event["state"] == "deleted")
        event = client->NextEvent();
      ++(event["state"] == "done" ? done : failed);
      if (fault) {
        client->Call("simulation.fault", {{"device", "rangefinder"}, {"fault", "none"}});
        client->Call("station.reset");
      } else if (event["state"] == "done") {
        client->Call("object.describe");
      }
      // The time until the next scan passes; the wall clock's too, as the housekeeping sees it.
      world->Advance(std::chrono::duration_cast<std::chrono::nanoseconds>(gap));
      if (i % 14 == 0) {
        const auto passed = std::chrono::duration_cast<std::chrono::seconds>(gap * i);
        server.Post([=](Service& service) { service.KeepHouse(start_wall + passed, start_steady + passed); });
      }
      if (i % std::max(1, scans / 40) == 0) {
        malloc_trim(0);
        at.push_back(i);
        memory.push_back(Metric(server, "process_resident_memory_bytes") / 1e6);
        descriptors.push_back(Metric(server, "process_open_fds"));
        if (at.size() % 4 == 0) {
          std::printf("%8d %10.1f %8.0f %12.2f %12.0f %10.0f %10.1f\n", i, gap.count() * i / 86400.0,
                      static_cast<double>(std::clock()) / CLOCKS_PER_SEC, memory.back(), descriptors.back(),
                      Metric(server, "geond_scans_stored"), Metric(server, "geond_store_bytes") / 1e6);
          std::fflush(stdout);
        }
      }
    }
  }
  server.Stop();
  io.join();
  const std::size_t skip = at.size() / 4;
  const std::vector<double> x(at.begin() + static_cast<std::ptrdiff_t>(skip), at.end());
  const double slope = 1000.0 * Slope(x, {memory.begin() + static_cast<std::ptrdiff_t>(skip), memory.end()});
  const double fds = 1000.0 * Slope(x, {descriptors.begin() + static_cast<std::ptrdiff_t>(skip), descriptors.end()});
  std::printf("%d done, %d ended by faults and stops; memory %.3f MB, descriptors %.3f a thousand scans\n", done,
              failed, slope, fds);
  return slope < 1.0 && std::abs(fds) < 0.5 ? 0 : 1;
}
