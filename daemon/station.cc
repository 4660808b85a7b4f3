// SPDX-License-Identifier: Apache-2.0
#include "daemon/station.h"

#include <stdexcept>
#include <utility>

#include "core/base/error.h"
#include "core/base/progress.h"

namespace geond::daemon {

std::string HazardOf(const drivers::Lines::Inputs& inputs) {
  if (inputs.emergency_stop) return "the emergency stop is pressed";
  if (inputs.door_open) return "the door is open";
  return {};
}

Station::Station(StationDevices devices, StationGeometry geometry, StationOptions options)
    : devices_(std::move(devices)), geometry_(std::move(geometry)), options_(options) {
  if (!devices_.rangefinder || !devices_.turntable || !devices_.lines) {
    throw std::invalid_argument("Station: it needs a rangefinder, a turntable and lines");
  }
  devices_.rangefinder->OnFault([this] { OnDeviceFault(); });
  devices_.turntable->OnFault([this] { OnDeviceFault(); });
  MakeSafe();
}

Station::~Station() {
  devices_.rangefinder->OnFault(nullptr);
  devices_.turntable->OnFault(nullptr);
  StopNow();
  MakeSafe();
}

std::string Station::Hazard() const { return HazardOf(devices_.lines->inputs()); }

void Station::RefuseIfHazard(const char* call) const {
  const std::string hazard = Hazard();
  if (hazard.empty()) return;
  throw DeviceError("station", call, hazard, "Release the emergency stop, close the door, then reset the station");
}

void Station::OnFault(std::function<void(const std::string&)> listener) {
  const std::lock_guard lock(listener_mutex_);
  listener_ = std::move(listener);
}

void Station::OnDeviceFault() {
  std::string words;
  for (const drivers::DeviceInfo& device : devices()) {
    if (words.empty()) words = device.fault;  // before stopping makes others fail
  }
  StopNow();
  const std::lock_guard lock(listener_mutex_);
  if (listener_) listener_(words);
}

// The device that failed by itself is the reason, not what stopping did to the others.
void Station::ThrowIfFaulted() const {
  for (const drivers::DeviceInfo& device : {devices_.rangefinder->info(), devices_.turntable->info()}) {
    if (!device.fault.empty()) throw DeviceError("station", "expose", device.fault);
  }
}

void Station::Home(std::stop_token stop) {
  RefuseIfHazard("home");
  try {
    devices_.lines->SetMotor(true);
    devices_.turntable->Enable();
    devices_.turntable->Home(stop);
    homed_ = true;
  } catch (...) {
    MakeSafe();
    throw;
  }
  MakeSafe();
}

void Station::Start(std::stop_token stop) {
  try {
    RefuseIfHazard("start");
    ThrowIfStopped(stop);
    devices_.lines->SetMotor(true);
    devices_.turntable->Enable();
    if (!homed_) devices_.turntable->Home(stop);
    homed_ = true;
    devices_.rangefinder->Arm();
    ThrowIfStopped(stop);
    devices_.lines->SetLaser(true);
    // A stop between the question and the laser's switch must not leave it on.
    ThrowIfStopped(stop);
    RefuseIfHazard("start");
  } catch (...) {
    MakeSafe();
    throw;
  }
}

Exposure Station::Expose(double table_angle, std::stop_token stop) {
  RefuseIfHazard("expose");
  try {
    devices_.turntable->MoveTo(table_angle, stop);
  } catch (const DeviceError&) {
    ThrowIfFaulted();
    throw;
  }
  ThrowIfStopped(stop);
  if (options_.trigger == StationOptions::Trigger::kWire) {
    devices_.lines->PulseTrigger();
  } else {
    devices_.rangefinder->Trigger();
  }
  Exposure exposure = devices_.rangefinder->Read(options_.frame_timeout, stop);
  exposure.table_angle = devices_.turntable->angle();
  RefuseIfHazard("expose");
  if (options_.calibration) exposure = calib::Corrected(exposure, *options_.calibration);
  return exposure;
}

void Station::MakeSafe() noexcept {
  devices_.lines->AllOff();
  devices_.turntable->Halt();
  devices_.rangefinder->Disarm();
  devices_.turntable->Disable();
}

void Station::Reset() {
  MakeSafe();
  homed_ = false;
  RefuseIfHazard("reset");
  // Each is tried, whatever the other says.
  std::exception_ptr failure;
  try {
    devices_.rangefinder->Reset();
  } catch (const DeviceError&) {
    failure = std::current_exception();
  }
  devices_.turntable->Reset();
  if (failure) std::rethrow_exception(failure);
}

std::vector<drivers::DeviceInfo> Station::devices() const {
  return {devices_.rangefinder->info(), devices_.turntable->info(), devices_.lines->info()};
}

std::optional<double> Station::table_angle() {
  if (!homed_ || devices_.turntable->info().state == drivers::DeviceState::kFault) return std::nullopt;
  try {
    return devices_.turntable->angle();
  } catch (const DeviceError&) {
    return std::nullopt;  // the fault shows in devices()
  }
}

void Station::StopNow() noexcept {
  devices_.lines->AllOff();
  devices_.turntable->Halt();
}

ActiveStation::ActiveStation(Station& station, std::stop_token stop) : station_(station) { station_.Start(stop); }

}  // namespace geond::daemon
