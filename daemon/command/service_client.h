// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <functional>
#include <stop_token>
#include <string>

#include "daemon/rpc.h"

namespace geond::daemon {

// One connection of a client to geond, waiting for its answers. Lives on one thread.
class ServiceClient {
 public:
  // `address`: path of a Unix socket (with a slash), or "host:port". Empty: what GEOND_SOCKET says, else
  // /run/geond/geond.sock, else 127.0.0.1:7100. Over TCP it logs in with the token GEOND_TOKEN, if there is one. Throws
  // DeviceError if nobody answers, RpcError if there is no such token.
  explicit ServiceClient(std::string address = {}, std::stop_token stop = {});
  ~ServiceClient();
  ServiceClient(const ServiceClient&) = delete;
  ServiceClient& operator=(const ServiceClient&) = delete;

  // Calls a method and waits for its result; events that come meanwhile are kept for NextEvent. Throws RpcError as the
  // service answers it; DeviceError if the connection ends; Cancelled.
  Json Call(const std::string& method, const Json& params = Json::object());
  // The next event's params. Throws as Call.
  Json NextEvent();

  const Json& greeting() const { return greeting_; }
  const std::string& address() const { return address_; }

 private:
  Json ReadLine();

  std::string address_;
  std::stop_token stop_;
  int fd_ = -1;
  int next_id_ = 1;
  std::string received_;
  std::vector<Json> events_;
  Json greeting_;
};

}  // namespace geond::daemon
