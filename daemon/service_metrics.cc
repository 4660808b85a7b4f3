// SPDX-License-Identifier: Apache-2.0
#include <fstream>
#include <sstream>

#include <unistd.h>

#include "core/base/error.h"
#include "daemon/http_files.h"
#include "daemon/service.h"

namespace geond::daemon {
namespace {

// Bytes of memory that the program holds; 0 where the system does not say.
std::uint64_t ResidentBytes() {
  std::ifstream file("/proc/self/statm");
  std::uint64_t total = 0, resident = 0;
  file >> total >> resident;
  return file ? resident * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE)) : 0;
}

int OpenDescriptors() {
  std::error_code error;
  int count = 0;
  for (std::filesystem::directory_iterator entry("/proc/self/fd", error), end; !error && entry != end; entry.increment(error)) ++count;
  return count;
}

}  // namespace

std::filesystem::path Service::ScanFile(int id, const std::string& name) const {
  const std::optional<ScanSummary> scan = store_.Find(id);
  const bool inside = name.ends_with(".exposure") || name.ends_with(".part");
  if (!scan || scan->state != ScanState::kDone || inside || !IsPlainPath(name)) return {};
  return store_.Folder(id) / name;
}

void Service::CountSteps(int id) {
  try {
    const std::shared_ptr<const Json> description = Description(id);
    residuals_mm_.clear();
    for (const Json& part : description->at("parts")) {
      if (part.contains("residual_mm") && part["residual_mm"].is_number()) residuals_mm_.push_back(part["residual_mm"].get<double>());
    }
    if (!description->contains("seconds")) return;
    for (const auto& [step, seconds] : description->at("seconds").items()) {
      if (seconds.is_number()) step_seconds_[step] = seconds.get<double>();
    }
  } catch (const std::exception&) {
    // The description shows its own error when it is asked for.
  }
}

std::string Service::Metrics() const {
  std::ostringstream text;
  const auto metric = [&](const char* name, const char* type, const char* help) {
    text << "# HELP " << name << " " << help << "\n# TYPE " << name << " " << type << "\n";
  };
  const auto number = [&](const char* name, const char* type, const char* help, auto value) {
    metric(name, type, help);
    text << name << " " << value << "\n";
  };
  metric("geond_info", "gauge", "Version and kind of station.");
  text << "geond_info{version=\"" << GEOND_VERSION << "\",station=\"" << (simulation_ ? "simulated" : "hardware") << "\"} 1\n";
  metric("geond_scans_ended_total", "counter", "Scans that ended since the start, by how.");
  for (const ScanState state : {ScanState::kDone, ScanState::kFailed, ScanState::kCancelled}) {
    const auto count = scans_ended_.find(std::string(ScanStateName(state)));
    text << "geond_scans_ended_total{state=\"" << ScanStateName(state) << "\"} " << (count == scans_ended_.end() ? 0 : count->second) << "\n";
  }
  number("geond_views_total", "counter", "Range images taken and safe on disk.", views_);
  number("geond_scans_stored", "gauge", "Scans in the store.", store_.count());
  number("geond_store_bytes", "gauge", "Bytes of all scans.", store_.bytes());
  number("geond_store_free_bytes", "gauge", "Bytes that the disk of the store has left.", store_.free_bytes());
  metric("geond_step_seconds", "gauge", "Wall time of each step of the last scan.");
  for (const auto& [step, seconds] : step_seconds_) text << "geond_step_seconds{step=\"" << step << "\"} " << seconds << "\n";
  metric("geond_part_residual_mm", "gauge", "Residual of the geon chosen for each part of the last scan.");
  for (std::size_t i = 0; i < residuals_mm_.size(); ++i) {
    text << "geond_part_residual_mm{part=\"" << i + 1 << "\"} " << residuals_mm_[i] << "\n";
  }
  number("geond_clients", "gauge", "Connections of clients.", clients_.size());
  number("geond_requests_total", "counter", "Requests of all clients.", requests_);
  metric("geond_refused_total", "counter", "What was not answered, and clients that were dropped, by why.");
  for (const auto& [why, count] : refusals_) text << "geond_refused_total{why=\"" << why << "\"} " << count << "\n";
  number("geond_events_total", "counter", "Events published.", events_);
  metric("geond_queue", "gauge", "Tasks that wait or run, by thread.");
  text << "geond_queue{thread=\"device\"} " << device_thread_.waiting() << "\ngeond_queue{thread=\"compute\"} " << compute_thread_.waiting() << "\n";
  number("geond_busy", "gauge", "1 while the station does something.", state_ == State::kIdle ? 0 : 1);
  number("geond_latched", "gauge", "1 while a person must reset the station.", latched_.empty() ? 0 : 1);
  number("geond_device_faults_total", "counter", "Work that ended with a fault of a device.", faults_);
  metric("geond_device_fault", "gauge", "1 while a device is in fault or absent.");
  for (const drivers::DeviceInfo& device : devices_) {
    const bool fault = device.state == drivers::DeviceState::kFault || device.state == drivers::DeviceState::kAbsent;
    text << "geond_device_fault{device=\"" << device.name << "\"} " << (fault ? 1 : 0) << "\n";
  }
  number("process_resident_memory_bytes", "gauge", "Memory that geond holds.", ResidentBytes());
  number("process_open_fds", "gauge", "Open files and sockets.", OpenDescriptors());
  return text.str();
}

}  // namespace geond::daemon
