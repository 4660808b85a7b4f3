// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <future>
#include <memory>
#include <string>

#include <gtest/gtest.h>

#include "daemon/service.h"
#include "tests/daemon/small_station.h"

namespace geond::daemon {

// A service on a simulated world with an I/O thread of its own, asked as a client asks.
class ServedTest : public testing::Test {
 protected:
  explicit ServedTest(std::shared_ptr<sim::SimStation> world) : world_(std::move(world)) {}
  ~ServedTest() override {
    if (io_) Close();
  }

  // With a small scan of `views` views.
  Config SmallConfig(int views) const {
    Config config;
    config.store_folder = (folder_.path() / "store").string();
    config.scan_views = views;
    config.scan_triangles = 300;
    config.scan_picture = false;
    config.scan_threads = 1;
    return config;
  }
  // Begins a life of the service, its events told to `on_event` on the I/O thread.
  void Open(const Config& config, std::function<void(const Json&)> on_event) {
    io_ = std::make_unique<WorkThread>();
    OnIo([&] {
      service_ = std::make_unique<Service>(config, SmallStation(world_),
                                           [this](std::function<void()> task) { io_->Post(std::move(task)); });
      client_ = std::make_unique<Client>();
      client_->send = [on_event](const std::string& line) { on_event(Json::parse(line)["params"]); };
      service_->AddClient(client_.get());
    });
    Call("events.subscribe");
  }
  void Close() {
    OnIo([this] { service_.reset(); });
    io_.reset();
  }

  template <typename Task>
  void OnIo(const Task& task) {
    std::promise<void> done;
    io_->Post([&] {
      task();
      done.set_value();
    });
    done.get_future().wait();
  }
  // The whole response to a request.
  Json Ask(const std::string& method, const Json& params = Json::object()) {
    std::promise<Json> answer;
    io_->Post([&] {
      service_->methods().Handle(Request(method, params), *client_,
                                 [&](const std::string& text) { answer.set_value(Json::parse(text)); });
    });
    return answer.get_future().get();
  }
  Json Call(const std::string& method, const Json& params = Json::object()) {
    const Json response = Ask(method, params);
    EXPECT_TRUE(response.contains("result")) << response.dump();
    return response.contains("result") ? response["result"] : Json();
  }

  TemporaryFolder folder_;
  std::shared_ptr<sim::SimStation> world_;
  std::unique_ptr<WorkThread> io_;
  std::unique_ptr<Service> service_;
  std::unique_ptr<Client> client_;
};

}  // namespace geond::daemon
