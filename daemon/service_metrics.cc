// SPDX-License-Identifier: Apache-2.0
#include <sstream>

#include "core/base/error.h"
#include "daemon/http_files.h"
#include "daemon/service.h"

namespace geond::daemon {

std::filesystem::path Service::ScanFile(int scan, const std::string& name) const {
  const auto found = store_.scans().find(scan);
  const bool inside = name.ends_with(".exposure") || name.ends_with(".part");
  if (found == store_.scans().end() || found->second.state != ScanState::kDone || inside || !IsPlainPath(name)) return {};
  return store_.Folder(scan) / name;
}

void Service::CountSteps(int id) {
  try {
    const std::shared_ptr<const Json> description = Description(id);
    if (!description->contains("seconds")) return;
    for (const auto& [step, seconds] : description->at("seconds").items()) {
      if (seconds.is_number()) step_seconds_[step] = seconds.get<double>();
    }
  } catch (const Error&) {
    // The description shows its own error when it is asked for.
  }
}

std::string Service::Metrics() const {
  std::ostringstream text;
  const auto metric = [&](const char* name, const char* type, const char* help) {
    text << "# HELP " << name << " " << help << "\n# TYPE " << name << " " << type << "\n";
  };
  metric("geond_info", "gauge", "Version and kind of station.");
  text << "geond_info{version=\"" << GEOND_VERSION << "\",station=\"" << (simulation_ ? "simulated" : "hardware") << "\"} 1\n";
  metric("geond_scans_ended_total", "counter", "Scans that ended since the start, by how.");
  for (const ScanState state : {ScanState::kDone, ScanState::kFailed, ScanState::kCancelled}) {
    const auto count = scans_ended_.find(std::string(ScanStateName(state)));
    text << "geond_scans_ended_total{state=\"" << ScanStateName(state) << "\"} " << (count == scans_ended_.end() ? 0 : count->second) << "\n";
  }
  metric("geond_scans_stored", "gauge", "Scans in the store.");
  text << "geond_scans_stored " << store_.scans().size() << "\n";
  metric("geond_step_seconds", "gauge", "Wall time of each step of the last scan.");
  for (const auto& [step, seconds] : step_seconds_) text << "geond_step_seconds{step=\"" << step << "\"} " << seconds << "\n";
  metric("geond_clients", "gauge", "Connections of clients.");
  text << "geond_clients " << clients_.size() << "\n";
  metric("geond_events_total", "counter", "Events published.");
  text << "geond_events_total " << events_ << "\n";
  metric("geond_busy", "gauge", "1 while the station does something.");
  text << "geond_busy " << (state_ == State::kIdle ? 0 : 1) << "\n";
  metric("geond_latched", "gauge", "1 while a person must reset the station.");
  text << "geond_latched " << (latched_.empty() ? 0 : 1) << "\n";
  metric("geond_device_fault", "gauge", "1 while a device is in fault or absent.");
  for (const drivers::DeviceInfo& device : devices_) {
    const bool fault = device.state == drivers::DeviceState::kFault || device.state == drivers::DeviceState::kAbsent;
    text << "geond_device_fault{device=\"" << device.name << "\"} " << (fault ? 1 : 0) << "\n";
  }
  return text.str();
}

}  // namespace geond::daemon
