// SPDX-License-Identifier: Apache-2.0
#include "daemon/service.h"

#include <fstream>
#include <future>
#include <sstream>

#include <gtest/gtest.h>

#include "tests/daemon/served_test.h"

namespace geond::daemon {
namespace {

using sim::Device;
using sim::Fault;

class ServiceTest : public ServedTest {
 protected:
  ServiceTest() : ServedTest(SmallWorld()) { Open(); }

  void Open() {
    ServedTest::Open(SmallConfig(4), [this](const Json& event) { OnEvent(event); });
  }
  std::string ErrorName(const std::string& method, const Json& params = Json::object()) {
    const Json response = Ask(method, params);
    return response.contains("error") ? response["error"]["data"]["name"].get<std::string>() : "no error";
  }

  // Runs on the I/O thread.
  void OnEvent(const Json& event) {
    events_.push_back(event);
    if (const auto act = on_event_) act(event);
    if (waiting_ && wanted_(event)) {
      auto found = std::exchange(waiting_, {});
      found->set_value(event);
    }
  }
  // Does `act`, then waits for the first event after it that is wanted.
  template <typename Act>
  Json EventAfter(const Act& act, std::function<bool(const Json&)> wanted) {
    auto found = std::make_shared<std::promise<Json>>();
    OnIo([&] {
      wanted_ = std::move(wanted);
      waiting_ = found;
    });
    act();
    return found->get_future().get();
  }
  // Runs a scan to its end; the event that says how it ended.
  Json ScanToEnd(const std::string& method = "scan.start", const Json& params = Json::object()) {
    return EventAfter([&] { Call(method, params); },
                      [](const Json& event) { return event["event"] == "scan" && event["state"] != "running"; });
  }

  std::vector<Json> events_;
  std::function<void(const Json&)> on_event_;
  std::function<bool(const Json&)> wanted_;
  std::shared_ptr<std::promise<Json>> waiting_;
};

TEST_F(ServiceTest, AScanGoesFromRequestToDescription) {
  const Json end = ScanToEnd("scan.start", {{"label", "egg"}});
  ASSERT_EQ(end["state"], "done") << end.dump();
  EXPECT_FALSE(world_->laser_emits());
  EXPECT_FALSE(world_->motor_powered());

  const Json description = Call("object.describe");
  EXPECT_EQ(description["scan"], 1);
  EXPECT_EQ(description["n_parts"], 1);
  EXPECT_EQ(description["parts"][0]["type"], "ellipsoid");
  EXPECT_EQ(Call("scan.status")["state"], "done");
  EXPECT_EQ(Call("object.list")["objects"][0]["label"], "egg");
  EXPECT_EQ(Call("station.status")["state"], "idle");
  for (const char* file : {"scan.json", "cloud.ply", "mesh.ply", "description.json", "journal.json"}) {
    EXPECT_TRUE(std::filesystem::exists(folder_.path() / "store/000001" / file)) << file;
  }
  EXPECT_FALSE(std::filesystem::exists(folder_.path() / "store/000001/view_000.exposure"));

  // Views come in order, each once, and steps in the order of the line.
  std::vector<int> views;
  std::vector<std::string> steps;
  for (const Json& event : events_) {
    if (event["event"] == "view") views.push_back(event["view"]);
    if (event["event"] == "progress" && (steps.empty() || steps.back() != event["step"])) steps.push_back(event["step"]);
  }
  EXPECT_EQ(views, (std::vector<int>{0, 1, 2, 3}));
  EXPECT_EQ(steps.front(), "acquire");
  EXPECT_EQ(steps.back(), "store");
}

TEST_F(ServiceTest, OneJobAtATimeAndItCanBeCancelled) {
  on_event_ = [this](const Json& event) {
    if (event["event"] != "view" || event["view"] != 1) return;
    on_event_ = {};
    std::string refused, cancelled;
    service_->methods().Handle(R"({"jsonrpc":"2.0","id":1,"method":"scan.start"})", *client_,
                               [&](std::string text) { refused = text; });
    EXPECT_NE(refused.find("\"busy\""), std::string::npos);
    service_->methods().Handle(R"({"jsonrpc":"2.0","id":1,"method":"scan.cancel"})", *client_,
                               [&](std::string text) { cancelled = text; });
    EXPECT_NE(cancelled.find("cancelling"), std::string::npos);
  };
  const Json end = ScanToEnd("scan.start", {{"views", 40}});
  EXPECT_EQ(end["state"], "cancelled");
  EXPECT_FALSE(world_->laser_emits());
  EXPECT_EQ(ErrorName("object.describe"), "not_found");
  EXPECT_EQ(ErrorName("object.describe", {{"scan", 1}}), "unavailable");
  EXPECT_EQ(ErrorName("scan.cancel"), "not_found");
}

TEST_F(ServiceTest, TheEmergencyStopLatchesUntilReset) {
  on_event_ = [this](const Json& event) {
    if (event["event"] != "view" || event["view"] != 1) return;
    on_event_ = {};
    world_->SetEmergencyStop(true);
    service_->OnLinesEvent();
  };
  const Json end = ScanToEnd("scan.start", {{"views", 40}});
  EXPECT_EQ(end["state"], "failed");
  EXPECT_EQ(end["error"]["data"]["name"], "unsafe");
  EXPECT_FALSE(world_->laser_emits());
  EXPECT_EQ(ErrorName("scan.start"), "unsafe");
  EXPECT_EQ(ErrorName("station.reset"), "unsafe");
  world_->SetEmergencyStop(false);
  OnIo([this] { service_->OnLinesEvent(); });
  EXPECT_EQ(ErrorName("scan.start"), "unsafe") << "released is not reset";
  EXPECT_EQ(Call("station.reset")["latched"], "");
  EXPECT_EQ(ScanToEnd()["state"], "done");
}

TEST_F(ServiceTest, AnEmergencyStopDuringTheResetStaysLatched) {
  std::promise<Json> answer;
  OnIo([&] {
    service_->methods().Handle(R"({"jsonrpc":"2.0","id":1,"method":"station.reset"})", *client_,
                               [&](const std::string& text) { answer.set_value(Json::parse(text)); });
    world_->SetEmergencyStop(true);
    service_->OnLinesEvent();
    world_->SetEmergencyStop(false);
  });
  answer.get_future().wait();
  EXPECT_EQ(Call("station.status")["latched"], "the emergency stop is pressed");
  EXPECT_EQ(ErrorName("scan.start"), "unsafe");
  EXPECT_EQ(Call("station.reset")["latched"], "");
}

TEST_F(ServiceTest, DeviceFaultsAreToldInWordsAndMended) {
  Call("simulation.fault", {{"device", "turntable"}, {"fault", "off"}});
  const Json end = ScanToEnd();
  EXPECT_EQ(end["state"], "failed");
  EXPECT_EQ(end["error"]["data"]["name"], "device_failed");
  EXPECT_FALSE(end["error"]["data"]["remedy"].get<std::string>().empty());
  EXPECT_EQ(ErrorName("station.home"), "device_failed");
  Call("simulation.fault", {{"device", "turntable"}, {"fault", "none"}});
  Call("station.reset");
  const Json homed = Call("station.home");
  EXPECT_EQ(homed["state"], "idle");
  EXPECT_NEAR(homed["table_angle_deg"].get<double>(), 0.0, 0.3);
}

TEST_F(ServiceTest, AScanThatWasCutShortIsResumedToTheSameDescription) {
  const Json whole = ScanToEnd();
  ASSERT_EQ(whole["state"], "done");
  Json first = Call("object.describe");
  on_event_ = [this](const Json& event) {
    if (event["event"] == "view" && event["view"] == 1) world_->SetFault(Device::kRangefinder, Fault::kStuck);
  };
  ASSERT_EQ(ScanToEnd()["state"], "failed");
  on_event_ = {};
  world_->SetFault(Device::kRangefinder, Fault::kNone);
  Call("station.reset");
  EXPECT_GE(Call("scan.status", {{"scan", 2}})["views_taken"].get<int>(), 2);

  // The program dies and comes back; nothing that was acknowledged is lost.
  Close();
  events_.clear();
  Open();
  EXPECT_EQ(Call("scan.status", {{"scan", 2}})["state"], "failed");
  ASSERT_EQ(ScanToEnd("scan.resume", {{"scan", 2}})["state"], "done");
  std::vector<int> views;
  for (const Json& event : events_) {
    if (event["event"] == "view") views.push_back(event["view"]);
  }
  EXPECT_LE(views.size(), 2u);
  EXPECT_EQ(Call("object.describe")["parts"][0]["type"], first["parts"][0]["type"]);
  EXPECT_EQ(ErrorName("scan.resume", {{"scan", 2}}), "unavailable");
  EXPECT_EQ(ErrorName("scan.resume", {{"scan", 99}}), "not_found");
}

TEST_F(ServiceTest, ListsScansByPage) {
  for (int i = 0; i < 5; ++i) {
    Call("simulation.inputs", {{"door_open", false}});
    on_event_ = [this](const Json& event) {
      if (event["event"] == "view" && event["view"] == 0) {
        service_->StopAll("enough");
      }
    };
    EXPECT_EQ(ScanToEnd()["state"], "cancelled");
  }
  on_event_ = {};
  std::vector<int> ids;
  Json params = {{"limit", 2}};
  while (true) {
    const Json page = Call("scan.list", params);
    for (const Json& scan : page["scans"]) ids.push_back(scan["scan"]);
    if (page["next"].is_null()) break;
    params["before"] = page["next"];
  }
  EXPECT_EQ(ids, (std::vector<int>{5, 4, 3, 2, 1}));
  Call("scan.delete", {{"scan", 3}});
  EXPECT_EQ(ErrorName("scan.status", {{"scan", 3}}), "not_found");
}

TEST_F(ServiceTest, OldScansGoUnlessPinnedOrTheClockWasSet) {
  using namespace std::chrono_literals;
  on_event_ = [this](const Json& event) {
    if (event["event"] == "view" && event["view"] == 0) service_->StopAll("enough");
  };
  for (int i = 0; i < 3; ++i) EXPECT_EQ(ScanToEnd()["state"], "cancelled");
  on_event_ = {};
  EXPECT_EQ(Call("scan.pin", {{"scan", 2}})["pinned"], true);
  const auto now = std::chrono::system_clock::now();
  const auto steady = std::chrono::steady_clock::now();
  const auto keep_house = [&](std::chrono::hours wall, std::chrono::hours real) {
    OnIo([&] { service_->KeepHouse(now + wall, steady + real); });
    return Call("store.status")["scans"];
  };
  Config config = SmallConfig(4);
  config.store_max_age_days = 2;
  OnIo([&] { service_->Reload(config); });
  EXPECT_EQ(keep_house(0h, 0h), 3);
  EXPECT_EQ(keep_house(1000h, 1h), 3) << "the clock was set";
  EXPECT_EQ(keep_house(1h, 2h), 3) << "and back";
  EXPECT_EQ(keep_house(50h, 51h), 1) << "so much time has passed";
  EXPECT_EQ(ErrorName("scan.status", {{"scan", 1}}), "not_found");
  EXPECT_EQ(Call("scan.status", {{"scan", 2}})["pinned"], true);
  EXPECT_EQ(Call("scan.pin", {{"scan", 2}, {"pinned", false}})["pinned"], false);
  EXPECT_EQ(keep_house(52h, 53h), 0);
}

TEST_F(ServiceTest, TheReferencePageSaysWhatTheTableSays) {
  const std::string reference = ApiReference(Call("rpc.discover"));
  std::ifstream file(std::string(GEOND_SOURCE_DIR) + "/docs/api.md");
  std::ostringstream text;
  text << file.rdbuf();
  EXPECT_EQ(text.str(), reference) << "write it anew: geon api --markdown > docs/api.md";
}

TEST_F(ServiceTest, EveryMethodAnswersWhatItDeclares) {
  ASSERT_EQ(ScanToEnd()["state"], "done");
  const Json document = Call("rpc.discover");
  EXPECT_GE(document["methods"].size(), 18u);
  for (const char* name : {"station.status", "devices.list", "scan.status", "scan.list", "object.list", "config.show",
                           "store.status", "log.tail", "scan.export"}) {
    const Json answer = Call(name);
    for (const Json& method : document["methods"]) {
      if (method["name"] != name) continue;
      for (const auto& [key, value] : answer.items()) {
        EXPECT_TRUE(method["result"]["schema"]["properties"].contains(key)) << name << " answers " << key;
      }
    }
  }
}

}  // namespace
}  // namespace geond::daemon
