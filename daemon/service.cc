// SPDX-License-Identifier: Apache-2.0
#include "daemon/service.h"

#include <spdlog/spdlog.h>

#include "core/base/error.h"
#include "daemon/log.h"

namespace geond::daemon {

std::string_view StateName(Service::State state) {
  switch (state) {
    case Service::State::kIdle: return "idle";
    case Service::State::kHoming: return "homing";
    case Service::State::kResetting: return "resetting";
    case Service::State::kAcquiring: return "acquiring";
    case Service::State::kModelling: return "modelling";
  }
  return "idle";
}

namespace {

StoreLimits LimitsOf(const Config& config) {
  return {std::chrono::hours(24) * config.store_max_age_days, static_cast<std::uint64_t>(config.store_max_size_gb * 1e9),
          static_cast<std::uint64_t>(config.store_min_free_mb) << 20};
}

}  // namespace

Service::Service(const Config& config, OpenedStation station, Post to_io)
    : config_(config),
      to_io_(std::move(to_io)),
      tokens_(config.api_tokens.empty() ? AccessTokens() : AccessTokens(config.folder / config.api_tokens)),
      store_(config.folder / config.store_folder, LimitsOf(config)),
      calibrations_(config.folder / config.store_folder / "calibrations"),
      simulation_(std::move(station.simulation)),
      station_(std::move(station.station)) {
  devices_ = station_->devices();
  LoadCalibration();
  station_->OnFault([this](const std::string& words) { OnIo([this, words] { OnDeviceFault(words); }); });
  AddMethods();
  OnLinesEvent();
}

Service::~Service() {
  station_->OnFault(nullptr);
  self_.reset();
  if (job_) job_->stop.request_stop();
  device_stop_.request_stop();
  station_->StopNow();
}

void Service::Reload(const Config& config) {
  for (const ConfigKey* key : ChangedKeys(config_, config)) {
    const std::string name(key->name);
    if (!key->reloadable) {
      spdlog::warn("{} has changed in the file; that needs a restart", name);
      continue;
    }
    Config changed = config;
    std::visit([](auto* to, auto* from) {
      if constexpr (std::is_same_v<decltype(to), decltype(from)>) *to = *from;
    }, key->field(config_), key->field(changed));
    spdlog::info("{} is taken over from the file", name);
  }
  store_.SetLimits(LimitsOf(config_));
  spdlog::set_level(spdlog::level::from_str(config_.log_level));
}

void Service::Answer(std::string_view line, Client& client, const std::function<void(std::string)>& respond) {
  ++requests_;
  if (client.rate.Allows(config_.api_max_requests_per_s, std::chrono::steady_clock::now())) {
    methods_.Handle(line, client, respond);
    return;
  }
  CountRefusal("rate_limited");
  const RpcError error(RpcError::Code::kRateLimited,
                       "more than " + std::to_string(config_.api_max_requests_per_s) + " requests a second",
                       "Ask less often, subscribe to events (events.subscribe), or raise api.max_requests_per_s");
  respond(Json{{"jsonrpc", "2.0"}, {"id", RequestId(line)}, {"error", error.ToJson()}}.dump());
}

std::string Service::Greeting() const {
  return Json{{"jsonrpc", "2.0"},
              {"method", "greeting"},
              {"params",
               {{"service", "geond"},
                {"protocol", 1},
                {"version", GEOND_VERSION},
                {"station", simulation_ ? "simulated" : "hardware"}}}}
      .dump();
}

void Service::OnIo(std::function<void()> task) {
  to_io_([self = std::weak_ptr(self_), task = std::move(task)] {
    if (self.lock()) task();
  });
}

void Service::Publish(const std::string& event, Json params) {
  Json all = {{"event", event}, {"number", ++events_}};
  all.update(params);
  std::string line;
  for (Client* client : clients_) {
    if (!client->subscribed || !client->send) continue;
    if (line.empty()) {
      line = Json{{"jsonrpc", "2.0"}, {"method", "event"}, {"params", std::move(all)}}.dump(
          -1, ' ', false, Json::error_handler_t::replace);
    }
    client->send(line);
  }
}

void Service::Enter(State state) {
  if (state == state_) return;
  state_ = state;
  Publish("state", {{"state", StateName(state_)}, {"latched", latched_}});
}

void Service::TakeSnapshot() {
  OnIo([this, devices = station_->devices(), angle = station_->table_angle()] {
    devices_ = devices;
    table_angle_ = angle;
  });
}

void Service::OnLinesEvent() {
  std::string hazard;
  try {
    hazard = HazardOf(station_->lines().ReadEvents());
  } catch (const DeviceError& error) {
    hazard = std::string("the wires cannot be read: ") + error.cause();
  }
  if (hazard.empty()) {
    Publish("lines", {{"hazard", ""}});
    return;
  }
  station_->StopNow();
  ++hazards_;
  // An open door forbids only what is in motion; the emergency stop and unreadable wires want a person's reset.
  const bool in_motion = state_ == State::kAcquiring || state_ == State::kHoming;
  if (in_motion || hazard != HazardOf({false, true})) latched_ = hazard;
  spdlog::warn("laser and motor are off: {}", hazard);
  if (in_motion) {
    device_stop_.request_stop();
    if (job_) {
      job_->stop_reason = hazard;
      job_->stop.request_stop();
    }
  }
  Publish("lines", {{"hazard", hazard}, {"latched", latched_}});
}

// Laser and motor are off by now; a scan ends with what it has.
void Service::OnDeviceFault(const std::string& words) {
  devices_ = station_->devices();
  spdlog::warn("laser and motor are off: {}", words);
  if (state_ == State::kAcquiring || state_ == State::kHoming) {
    device_stop_.request_stop();
    if (job_ && state_ == State::kAcquiring) {
      if (job_->stop_reason.empty()) job_->stop_reason = words;
      job_->stop.request_stop();
    }
  }
  Publish("fault", {{"fault", words}});
}

void Service::StopAll(const std::string& reason) {
  if (job_) job_->stop.request_stop();
  device_stop_.request_stop();
  station_->StopNow();
  spdlog::info("stopped: {}", reason);
}

std::string Service::StatusText() const {
  std::string text(StateName(state_));
  if (job_) text += " scan " + std::to_string(job_->id) + ", " + job_->step;
  if (!latched_.empty()) text += "; " + latched_ + ", reset needed";
  return text;
}

bool Service::ThreadsAlive() {
  const std::uint64_t device = device_thread_.progress(), compute = compute_thread_.progress();
  const bool alive = (device_thread_.idle() || device != device_seen_) && (compute_thread_.idle() || compute != compute_seen_);
  device_seen_ = device;
  compute_seen_ = compute;
  return alive;
}

}  // namespace geond::daemon
