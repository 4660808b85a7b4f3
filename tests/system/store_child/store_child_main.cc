// SPDX-License-Identifier: Apache-2.0
// One life of the service on a store, for tests that end it: store_child FOLDER CRASH_AT LOSS SEED. It takes up the
// newest scan if that has no description, else begins one (of four noiseless views), and says line by line what it
// would have told a client: "found STATE VIEWS", "view N" once that view is acknowledged, "done DESCRIPTION", "calls
// N". CRASH_AT, LOSS (nothing, all, torn) and SEED are those of losing_disk.
#include <cstdio>
#include <cstdlib>
#include <future>
#include <string>

#include <fcntl.h>
#include <unistd.h>

#include "daemon/service.h"
#include "tests/daemon/small_station.h"
#include "tests/system/store_child/losing_disk.h"

namespace {

using namespace geond;
using namespace geond::daemon;

void Say(const std::string& line) {
  const std::string whole = line + "\n";
  if (write(STDOUT_FILENO, whole.data(), whole.size()) < 0) _exit(3);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 5) return 2;
  const std::string folder = argv[1], loss = argv[3];
  losing_disk::Arm(folder, std::atoi(argv[2]),
                   loss == "all"    ? losing_disk::Loss::kAll
                   : loss == "torn" ? losing_disk::Loss::kTorn
                                    : losing_disk::Loss::kNothing,
                   std::strtoull(argv[4], nullptr, 10));
  Config config;
  config.store_folder = folder;
  config.scan_views = 4;
  config.scan_triangles = 150;
  config.scan_picture = false;
  config.scan_threads = 1;
  std::promise<Json> ended;
  WorkThread io;
  std::unique_ptr<Service> service;
  Client client;
  client.send = [&](const std::string& line) {
    const Json event = Json::parse(line)["params"];
    if (event["event"] == "view") Say("view " + event["view"].dump());
    if (event["event"] == "scan" && event["state"] != "running") ended.set_value(event);
  };
  const auto ask = [&](const std::string& method, const Json& params) {
    Json answer;
    service->methods().Handle(Request(method, params), client,
                              [&](const std::string& text) { answer = Json::parse(text); });
    return answer;
  };
  std::promise<int> begun;
  io.Post([&] {
    try {
      const auto world = NoiselessWorld(40);
      service = std::make_unique<Service>(config, SmallStation(world),
                                          [&](std::function<void()> task) { io.Post(std::move(task)); });
    } catch (const std::exception& error) {
      Say(std::string("error ") + error.what());
      _exit(1);
    }
    client.subscribed = true;
    service->AddClient(&client);
    const Json newest = ask("scan.status", Json::object());
    const bool known = newest.contains("result");
    if (known)
      Say("found " + newest["result"]["state"].get<std::string>() + " " + newest["result"]["views_taken"].dump());
    if (known && newest["result"]["state"] == "done") {
      begun.set_value(0);
      return;
    }
    const Json started =
        known ? ask("scan.resume", {{"scan", newest["result"]["scan"]}}) : ask("scan.start", Json::object());
    if (!started.contains("result")) {
      Say("error " + started.dump());
      _exit(1);
    }
    Say("begun 1");
    begun.set_value(1);
  });
  if (begun.get_future().get() == 1) {
    const Json end = ended.get_future().get();
    if (end["state"] != "done") Say("error " + end.dump());
  }
  std::promise<void> told;
  io.Post([&] {
    Json description = ask("object.describe", Json::object());
    if (description.contains("result")) {
      description["result"].erase("seconds");
      description["result"].erase("scan");  // a folder that a crash left before anybody heard of it keeps its number
      Say("done " + description["result"].dump());
    }
    service.reset();
    told.set_value();
  });
  told.get_future().get();
  Say("calls " + std::to_string(losing_disk::calls()));
  return 0;
}
