// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "daemon/config.h"
#include "daemon/open_station.h"

namespace geond::daemon {

class Service;

// Reads what a configuration names besides keys and numbers: tokens, networks, simulation, certificate. Throws ConfigError or
// FileError for the first that is wrong. Opens nothing.
void CheckNamedFiles(const Config& config);

// geond from its first to its last breath: the I/O thread, its sockets, the service behind them.
class Server {
 public:
  // Opens station, store and sockets. Throws Error if one of them cannot be opened.
  Server(const Config& config, OpenedStation station);
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  // Serves until Stop; the calling thread is the I/O thread. With `signals`, SIGTERM and SIGINT stop it, and SIGHUP calls
  // `reload` for the configuration to take over.
  void Run(bool signals = false, const std::function<Config()>& reload = {});
  // Safe from any thread.
  void Stop();

  // The TCP port it listens on.
  int port() const;
  // That of the robot port; -1: none.
  int robot_port() const;
  // That of the page and of HTTP; -1: none.
  int http_port() const;
  // For tests: runs a task on the I/O thread. Safe from any thread.
  void Post(std::function<void(Service&)> task);

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace geond::daemon
