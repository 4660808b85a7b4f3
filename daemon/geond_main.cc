// SPDX-License-Identifier: Apache-2.0
// geond: the service that runs a scanning station.
#include <csignal>
#include <iostream>

#include <CLI/CLI.hpp>
#include <spdlog/spdlog.h>

#include "core/base/error.h"
#include "daemon/config.h"
#include "daemon/hardware_station.h"
#include "daemon/log.h"
#include "daemon/open_station.h"
#include "daemon/server.h"

namespace {

using namespace geond::daemon;

Config Configuration(const std::string& path, const std::vector<std::string>& settings) {
  Config config = path.empty() ? Config{} : ReadConfig(path);
  for (const std::string& setting : settings) SetConfigKey(config, setting);
  if (!settings.empty()) CheckConfig(config, "--set");
  return config;
}

void Serve(const Config& config, const std::function<Config()>& reload) {
  OpenLog(config.log_level);
  Server server(config, OpenStation(config));
  spdlog::info("geond {} serves a {} station on {}:{}{}", GEOND_VERSION, config.station_kind, config.api_address, server.port(),
               config.api_unix_socket.empty() ? "" : " and " + config.api_unix_socket);
  if (server.http_port() >= 0) {
    spdlog::info("the page is at {}://{}:{}", config.http_certificate.empty() ? "http" : "https", config.http_address, server.http_port());
  }
  if (server.robot_port() >= 0) spdlog::info("robots ask on port {}", server.robot_port());
  server.Run(true, reload);
  spdlog::info("geond ends");
}

// Each device is switched off whatever the others say; what does not work is told. A simulated one has nothing on.
int SwitchOff(const Config& config) {
  if (config.station_kind != "hardware") return 0;
  const std::vector<std::string> failures = SwitchHardwareOff(config);
  for (const std::string& failure : failures) std::cerr << "geond: " << failure << std::endl;
  return failures.empty() ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  std::signal(SIGPIPE, SIG_IGN);
  CLI::App app("geond: runs a scanning station and describes what it scans; `geon` talks to it", "geond");
  std::string path;
  std::vector<std::string> settings;
  bool check = false, print = false, safe_off = false;
  app.set_version_flag("--version", std::string("geond ") + GEOND_VERSION);
  app.add_option("--config", path, "Configuration file; without it, every key has its default");
  app.add_option("--set", settings, "Overrides one key: --set scan.views=12 (may be repeated)")->take_all();
  app.add_flag("--check", check, "Only check the configuration and the files it names");
  app.add_flag("--safe-off", safe_off, "Only switch laser and motor off, as after a crash");
  app.add_flag("--print-config", print, "Only print the configuration in force, every key with its meaning");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  try {
    const Config config = Configuration(path, settings);
    if (print) {
      std::cout << ConfigText(config);
    } else if (check) {
      CheckNamedFiles(config);
      std::cout << (path.empty() ? "The defaults" : path) << ": fine\n";
    } else if (safe_off) {
      return SwitchOff(config);
    } else {
      Serve(config, [&] { return Configuration(path, settings); });
    }
    return 0;
  } catch (const std::exception& error) {
    std::cerr << "geond: " << error.what() << std::endl;
    return 1;
  }
}
