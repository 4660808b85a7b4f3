// SPDX-License-Identifier: Apache-2.0
#include <ctime>
#include <numbers>

#include "core/base/error.h"
#include "daemon/service.h"
#include "sim/fault.h"

namespace geond::daemon {
namespace {

using Code = RpcError::Code;

constexpr std::size_t kDescriptionsKept = 64;
constexpr int kMostWrongLogins = 5;

Json DeviceJson(const drivers::DeviceInfo& device) {
  return {{"name", device.name},     {"driver", device.driver}, {"model", device.model},
          {"serial", device.serial}, {"state", drivers::DeviceStateName(device.state)}, {"fault", device.fault}};
}

// "2026-01-31T12:00:00Z"
std::string UtcText(std::chrono::system_clock::time_point time) {
  const std::time_t seconds = std::chrono::system_clock::to_time_t(time);
  std::tm parts{};
  gmtime_r(&seconds, &parts);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &parts);
  return text;
}

}  // namespace

Json Service::StatusJson() {
  Json devices = Json::array();
  for (const drivers::DeviceInfo& device : devices_) devices.push_back(DeviceJson(device));
  Json status = {{"state", StateName(state_)},
                 {"latched", latched_},
                 {"station", simulation_ ? "simulated" : "hardware"},
                 {"version", GEOND_VERSION},
                 {"http", http_url_},
                 {"uptime_s", std::chrono::duration<double>(std::chrono::steady_clock::now() - started_).count()},
                 {"clients", clients_.size()},
                 {"devices", std::move(devices)},
                 {"calibration", CalibrationStatus()},
                 {"table_angle_deg", table_angle_ ? Json(*table_angle_ * 180.0 / std::numbers::pi) : Json()},
                 {"laser", station_->lines().laser()},
                 {"motor", station_->lines().motor()}};
  try {
    const drivers::Lines::Inputs inputs = station_->lines().inputs();
    status["emergency_stop"] = inputs.emergency_stop;
    status["door_open"] = inputs.door_open;
  } catch (const DeviceError& error) {
    status["emergency_stop"] = status["door_open"] = nullptr;
    status["wires"] = error.what();
  }
  status["scan"] = nullptr;
  if (job_) {
    status["scan"] = {{"scan", job_->id},       {"step", job_->step},   {"done", job_->done},
                      {"total", job_->total},   {"views", job_->views}, {"views_taken", job_->views_taken}};
  }
  return status;
}

Json Service::ScanJson(const ScanSummary& scan) const {
  Json json = {{"scan", scan.id},
               {"state", ScanStateName(scan.state)},
               {"label", scan.label},
               {"views", scan.views},
               {"views_taken", scan.views_taken},
               {"n_parts", scan.types.size()},
               {"types", scan.types},
               {"error", scan.error},
               {"pinned", scan.pinned},
               {"bytes", scan.bytes},
               {"ended", UtcText(scan.ended)},
               {"folder", store_.Folder(scan.id).string()}};
  if (job_ && job_->id == scan.id) {
    json["step"] = job_->step;
    json["done"] = job_->done;
    json["total"] = job_->total;
    json["views_taken"] = job_->views_taken;
  }
  return json;
}

int Service::ScanParameter(const Json& params, bool done) const {
  if (params.contains("scan")) {
    const int id = params["scan"].get<int>();
    const ScanSummary scan = FindScan(id);
    if (done && scan.state != ScanState::kDone) {
      throw RpcError(Code::kUnavailable,
                     "scan " + std::to_string(id) + " is " + std::string(ScanStateName(scan.state)) +
                         (scan.error.empty() ? "" : ": " + scan.error),
                     "Wait for it, or resume it (scan.resume)");
    }
    return id;
  }
  const int id = done ? store_.newest_done() : store_.newest();
  if (id == 0) throw RpcError(Code::kNotFound, "there is no scan yet", "Start one (scan.start)");
  return id;
}

ScanSummary Service::FindScan(int id) const {
  const std::optional<ScanSummary> scan = store_.Find(id);
  if (!scan) throw RpcError(Code::kNotFound, "there is no scan " + std::to_string(id), "scan.list says which there are");
  return *scan;
}

namespace {

// What `read` gives for a scan, read once and kept for a while.
template <typename Read>
std::shared_ptr<const Json> Kept(std::map<int, std::shared_ptr<const Json>>& kept, int id, const Read& read) {
  if (const auto found = kept.find(id); found != kept.end()) return found->second;
  auto json = std::make_shared<Json>(Json{{"scan", id}});
  json->update(Json::parse(read(id)));
  if (kept.size() >= kDescriptionsKept) kept.erase(kept.begin());
  return kept[id] = std::move(json);
}

}  // namespace

std::shared_ptr<const Json> Service::Description(int id) {
  return Kept(descriptions_, id, [this](int scan) { return store_.Description(scan); });
}

std::shared_ptr<const Json> Service::Grasps(int id) {
  return Kept(grasps_, id, [this](int scan) { return store_.Grasps(scan); });
}

void Service::AddMethods() {
  methods_.Add({"rpc.discover", Role::kRead, {}, RpcSchema({{"openrpc", "string"}, {"methods", "array"}}),
                "All methods, as an OpenRPC document.",
                [this](const Json&, Client&, const Reply& reply) { reply(methods_.Discover()); }});
  methods_.Add({"auth.login", Role::kNone, {{"token", "string", "A token of the file api.tokens names", true, 0, 0, {}}},
                RpcSchema({{"role", "string"}}), "Take the role of a token, for as long as the connection lasts.",
                [this](const Json& params, Client& client, const Reply& reply) {
                  const Role role = tokens_.RoleOf(params["token"].get<std::string>());
                  if (role == Role::kNone && ++client.wrong_logins < kMostWrongLogins) {
                    throw RpcError(Code::kForbidden, "there is no such token", "See api.tokens");
                  }
                  // Guessing must not be worth while: after a few, right ones are wrong as well on this connection.
                  if (client.wrong_logins >= kMostWrongLogins) {
                    throw RpcError(Code::kForbidden, "too many wrong tokens", "Connect anew with the right one");
                  }
                  client.role = role;
                  reply(Json{{"role", RoleName(role)}});
                }});
  AddStationMethods();
  AddScanMethods();
  AddStoreMethods();
  AddResultMethods();
  AddCalibrationMethods();
  if (simulation_) AddSimulationMethods();
}

void Service::AddStationMethods() {
  const Json status = RpcSchema({{"state", "string"}, {"latched", "string"}, {"station", "string"}, {"version", "string"},
                                 {"http", "string"}, {"uptime_s", "number"}, {"clients", "integer"}, {"devices", "array"},
                              {"calibration", "object"}, {"table_angle_deg", "number"}, {"laser", "boolean"}, {"motor", "boolean"},
                              {"emergency_stop", "boolean"}, {"door_open", "boolean"}, {"scan", "object"}});
  methods_.Add({"station.status", Role::kRead, {}, status, "What the station does, and how its devices are.",
                [this](const Json&, Client&, const Reply& reply) { reply(StatusJson()); }});
  methods_.Add({"station.home", Role::kScan, {}, status, "Find the turntable's zero; answers when it stands there.",
                [this](const Json&, Client&, const Reply& reply) {
                  RefuseIfUnsafe();
                  RunOnDevice(State::kHoming, [this](std::stop_token stop) { station_->Home(stop); }, reply);
                }});
  methods_.Add({"station.stop", Role::kScan, {}, status, "Laser off and motion stopped at once; ends what runs.",
                [this](const Json&, Client& client, const Reply& reply) {
                  StopAll("asked for by client " + std::to_string(client.id));
                  reply(StatusJson());
                }});
  methods_.Add({"station.reset", Role::kScan, {}, status,
                "Bring faulted devices back and allow motion again after a stop, once its cause is gone.",
                [this](const Json&, Client&, const Reply& reply) {
                  const std::string hazard = station_->Hazard();
                  if (!hazard.empty()) {
                    throw RpcError(Code::kUnsafe, hazard, "Release the emergency stop and close the door first");
                  }
                  RunOnDevice(State::kResetting, [this](std::stop_token) { station_->Reset(); }, reply);
                }});
  methods_.Add({"devices.list", Role::kRead, {}, RpcSchema({{"devices", "array"}}), "The devices and their faults in words.",
                [this](const Json&, Client&, const Reply& reply) { reply(Json{{"devices", StatusJson()["devices"]}}); }});
}

void Service::AddScanMethods() {
  const Json begun = RpcSchema({{"scan", "integer"}, {"state", "string"}});
  const Json scan = RpcSchema({{"scan", "integer"}, {"state", "string"}, {"label", "string"}, {"views", "integer"},
                            {"views_taken", "integer"}, {"n_parts", "integer"}, {"types", "array"}, {"error", "string"},
                            {"pinned", "boolean"}, {"bytes", "integer"}, {"ended", "string"}, {"folder", "string"},
                            {"step", "string"}, {"done", "integer"}, {"total", "integer"}});
  methods_.Add({"scan.start", Role::kScan,
                {{"views", "integer", "Range images, evenly round the table", false, 1, 360, {}},
                 {"first_angle_deg", "number", "Table angle of the first one", false, -360, 360, {}},
                 {"label", "string", "What the scan is called, for people", false, 0, 0, {}}},
                begun, "Scan the object on the table; answers at once, events tell how it goes.",
                [this](const Json& params, Client&, const Reply& reply) {
                  const double angle = params.value("first_angle_deg", config_.scan_first_angle_deg);
                  reply(StartScan(params.value("views", config_.scan_views), angle * std::numbers::pi / 180.0,
                                  params.value("label", std::string())));
                }});
  methods_.Add({"scan.resume", Role::kScan, {ScanIdParameter(true)}, begun,
                "Go on with a scan that was cut short, from the views that are safe.",
                [this](const Json& params, Client&, const Reply& reply) { reply(ResumeScan(params["scan"].get<int>())); }});
  methods_.Add({"scan.status", Role::kRead, {ScanIdParameter(false)}, scan, "How far a scan is, or how it ended.",
                [this](const Json& params, Client&, const Reply& reply) {
                  reply(ScanJson(FindScan(ScanParameter(params, false))));
                }});
  methods_.Add({"scan.cancel", Role::kScan, {}, begun, "End the scan that runs; what it has taken stays.",
                [this](const Json&, Client&, const Reply& reply) {
                  if (!job_) throw RpcError(Code::kNotFound, "no scan runs");
                  job_->stop.request_stop();
                  if (state_ == State::kAcquiring) station_->StopNow();
                  reply(Json{{"scan", job_->id}, {"state", "cancelling"}});
                }});
}

void Service::AddResultMethods() {
  methods_.Add({"object.describe", Role::kRead, {ScanIdParameter(false)},
                RpcSchema({{"scan", "integer"}, {"n_parts", "integer"}, {"parts", "array"}, {"relations", "array"},
                        {"seconds", "object"}, {"version", "string"}}),
                "The description of a scanned object, as `geon describe --json` prints it.",
                [this](const Json& params, Client&, const Reply& reply) {
                  const int id = ScanParameter(params, true);
                  reply(*Description(id));
                }});
  methods_.Add({"object.grasps", Role::kRead,
                {ScanIdParameter(false), {"part", "integer", "Id of the part; without it those of all", false, 1, 1e6, {}}},
                RpcSchema({{"scan", "integer"}, {"grasps", "array"}}),
                "How a parallel gripper can take the parts, best first: pose of the gripper in T, opening, clearance, reason.",
                [this](const Json& params, Client&, const Reply& reply) {
                  const std::shared_ptr<const Json> grasps = Grasps(ScanParameter(params, true));
                  if (!params.contains("part")) {
                    reply(*grasps);
                    return;
                  }
                  Json chosen = {{"scan", grasps->at("scan")}, {"grasps", Json::array()}};
                  for (const Json& grasp : grasps->at("grasps")) {
                    if (grasp["part"] == params["part"]) chosen["grasps"].push_back(grasp);
                  }
                  reply(std::move(chosen));
                }});
  methods_.Add({"events.subscribe", Role::kRead, {}, RpcSchema({{"subscribed", "boolean"}}),
                "Be told of state, progress, views and results as they come.",
                [](const Json&, Client& client, const Reply& reply) {
                  if (!client.send) throw RpcError(Code::kUnavailable, "this connection ends with its answer");
                  client.subscribed = true;
                  reply(Json{{"subscribed", true}});
                }});
  methods_.Add({"events.unsubscribe", Role::kRead, {}, RpcSchema({{"subscribed", "boolean"}}), "Be told no more.",
                [](const Json&, Client& client, const Reply& reply) {
                  client.subscribed = false;
                  reply(Json{{"subscribed", false}});
                }});
  methods_.Add({"config.show", Role::kRead, {}, RpcSchema({{"text", "string"}, {"values", "object"}}),
                "The configuration in force.", [this](const Json&, Client&, const Reply& reply) {
                  Json values = Json::object();
                  Config config = config_;
                  for (const ConfigKey& key : ConfigKeys()) {
                    std::visit([&](auto* value) { values[std::string(key.name)] = *value; }, key.field(config));
                  }
                  reply(Json{{"values", std::move(values)}, {"text", ConfigText(config_)}});
                }});
}

void Service::AddSimulationMethods() {
  std::vector<std::string> faults = {std::string(sim::FaultName(sim::Fault::kNone))}, devices;
  for (const sim::Fault fault : sim::kFaults) faults.emplace_back(sim::FaultName(fault));
  for (const sim::Device device : sim::kDevices) devices.emplace_back(sim::DeviceName(device));
  methods_.Add({"simulation.fault", Role::kAdmin,
                {{"device", "string", "Which device", true, 0, 0, devices}, {"fault", "string", "What is wrong with it", true, 0, 0, faults}},
                RpcSchema({{"device", "string"}, {"fault", "string"}}), "Break or mend a simulated device.",
                [this](const Json& params, Client&, const Reply& reply) {
                  simulation_->SetFault(sim::DeviceFromName(params["device"].get<std::string>()),
                                        sim::FaultFromName(params["fault"].get<std::string>()));
                  reply(params);
                }});
  methods_.Add({"simulation.inputs", Role::kAdmin,
                {{"emergency_stop", "boolean", "Pressed", false, 0, 0, {}}, {"door_open", "boolean", "Open", false, 0, 0, {}}},
                RpcSchema({{"emergency_stop", "boolean"}, {"door_open", "boolean"}}),
                "Press or release the simulated emergency stop, open or close the door.",
                [this](const Json& params, Client&, const Reply& reply) {
                  if (params.contains("emergency_stop")) simulation_->SetEmergencyStop(params["emergency_stop"].get<bool>());
                  if (params.contains("door_open")) simulation_->SetDoorOpen(params["door_open"].get<bool>());
                  reply(Json{{"emergency_stop", simulation_->emergency_stop()}, {"door_open", simulation_->door_open()}});
                }});
  methods_.Add({"simulation.scene", Role::kAdmin,
                {{"toml", "string", "Put this there: the text of a scene file", false, 0, 0, {}},
                 {"configured", "boolean", "Put there what stood there from the start", false, 0, 0, {}}},
                RpcSchema({{"name", "string"}}), "Change what stands on the simulated table; says what is there.",
                [this, configured = simulation_->scene()](const Json& params, Client&, const Reply& reply) {
                  RefuseIfBusy();
                  try {
                    if (params.value("configured", false)) simulation_->SetScene(configured);
                    if (params.contains("toml")) {
                      simulation_->SetScene(sim::ParseScene(params["toml"].get<std::string>(), config_.folder));
                    }
                  } catch (const ConfigError& error) {
                    throw RpcError(Code::kInvalidParams, error.what());
                  }
                  reply(Json{{"name", simulation_->scene().name}});
                }});
}

}  // namespace geond::daemon
