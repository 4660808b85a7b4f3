// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstdio>
#include <cstring>
#include <utility>

#include "core/base/error.h"
#include "core/base/progress.h"
#include "sim/random.h"
#include "sim/sim_devices.h"

namespace geond::sim {
namespace {

using drivers::DeviceState;
using std::chrono::milliseconds;

constexpr char kName[] = "rangefinder (simulated)";
constexpr milliseconds kTick(2);
constexpr int kSlowness = 20;

// A payload of random bits, as after a lost alignment.
void Scramble(RangeImage& image, std::uint64_t seed) {
  for (std::size_t i = 0; i < image.depth.size(); ++i) {
    CounterRandom random(seed, 0x67617262u, i);
    const auto bits = static_cast<std::uint32_t>(random.Uniform() * 4294967296.0);
    std::memcpy(&image.depth[i], &bits, sizeof bits);
  }
}

}  // namespace

void CheckFrame(const RangeImage& image, const SensorModel& sensor, const std::string& device) {
  if (image.columns != sensor.columns || image.rows != sensor.rows ||
      image.depth.size() != static_cast<std::size_t>(image.columns) * image.rows) {
    throw DeviceError(device, "read frame",
                      "the frame is " + std::to_string(image.columns) + " x " + std::to_string(image.rows) +
                          ", the device announced " + std::to_string(sensor.columns) + " x " +
                          std::to_string(sensor.rows),
                      "Reset the rangefinder");
  }
  std::size_t outside = 0;
  for (const float depth : image.depth)
    outside += !std::isnan(depth) && !(depth >= 0.0f && depth <= 1.001 * sensor.max_depth);
  if (outside > 0) {
    throw DeviceError(device, "read frame",
                      std::to_string(outside) + " of " + std::to_string(image.depth.size()) +
                          " depths are no number or out of the device's own range",
                      "Check the cable, then reset the rangefinder");
  }
}

SimRangefinder::SimRangefinder(std::shared_ptr<SimStation> station, TriggerSource source)
    : station_(std::move(station)), source_(source) {}

SimRangefinder::~SimRangefinder() { Disarm(); }

drivers::DeviceInfo SimRangefinder::info() const {
  const std::lock_guard lock(mutex_);
  const bool absent = station_->fault(Device::kRangefinder) == Fault::kOff;
  return {"rangefinder", "simulated", "geond range camera", "SIM-RANGE-1", absent ? DeviceState::kAbsent : state_,
          fault_text_};
}

SensorModel SimRangefinder::sensor_model() const { return station_->options().assumed.sensor; }

void SimRangefinder::CheckAnswers(const char* call) {
  if (station_->fault(Device::kRangefinder) != Fault::kOff) return;
  const std::lock_guard lock(mutex_);
  state_ = DeviceState::kFault;
  fault_text_ = "does not answer";
  throw DeviceError(kName, call, "the device does not answer", "Switch it on and check its cable");
}

void SimRangefinder::FailRead(const std::string& cause, bool timeout) {
  {
    const std::lock_guard lock(mutex_);
    state_ = DeviceState::kFault;
    fault_text_ = cause;
  }
  station_->SetEmission(false);
  const char* remedy = "Check that the laser is enabled and the trigger arrives, then reset the rangefinder";
  if (timeout) throw TimeoutError(kName, "read frame", cause, remedy);
  throw DeviceError(kName, "read frame", cause, remedy);
}

std::uint64_t SimRangefinder::triggers() const {
  return source_ == TriggerSource::kSoftware ? software_triggers_ : station_->trigger_count();
}

void SimRangefinder::Arm() {
  CheckAnswers("arm");
  {
    const std::lock_guard lock(mutex_);
    if (state_ == DeviceState::kFault)
      throw DeviceError(kName, "arm", "it is in fault: " + fault_text_, "Reset it first");
    state_ = DeviceState::kArmed;
  }
  station_->Advance(station_->options().reply_time);
  station_->SetEmission(true);
  used_triggers_ = triggers();
}

void SimRangefinder::Trigger() {
  CheckAnswers("trigger");
  {
    const std::lock_guard lock(mutex_);
    if (state_ != DeviceState::kArmed) throw DeviceError(kName, "trigger", "it is not armed", "Arm it first");
  }
  if (source_ == TriggerSource::kWire) return;
  ++software_triggers_;
  software_trigger_time_ = station_->now();
}

Exposure SimRangefinder::Read(std::chrono::milliseconds timeout, std::stop_token stop) {
  CheckAnswers("read frame");
  {
    const std::lock_guard lock(mutex_);
    if (state_ != DeviceState::kArmed) throw DeviceError(kName, "read frame", "it is not armed", "Arm it first");
  }
  const SimStation::Time deadline = station_->now() + timeout;
  bool laser_was_off = false;
  while (true) {
    ThrowIfStopped(stop);
    CheckAnswers("read frame");
    const Fault fault = station_->fault(Device::kRangefinder);
    const SimStation::Time now = station_->now();
    if (triggers() > used_triggers_) {
      const SimStation::Time triggered =
          source_ == TriggerSource::kSoftware ? software_trigger_time_ : station_->last_trigger();
      SimStation::Time latency = station_->options().exposure_time;
      if (fault == Fault::kSlow) latency *= kSlowness;
      if (fault == Fault::kDelayed) latency += timeout + std::chrono::seconds(1);
      laser_was_off = laser_was_off || !station_->laser_emits();
      const bool lost =
          fault == Fault::kStuck || (fault == Fault::kIntermittent && triggers() % 2 == 1) || laser_was_off;
      if (!lost && now >= triggered + latency) {
        used_triggers_ = triggers();
        Exposure exposure;
        exposure.image = station_->TakeImage();
        exposure.timestamp = now;
        if (fault == Fault::kGarbage) Scramble(exposure.image, station_->options().seed + frames_);
        if (fault == Fault::kWrong) {
          exposure.image.rows /= 2;
          exposure.image.depth.resize(static_cast<std::size_t>(exposure.image.columns) * exposure.image.rows);
        }
        ++frames_;
        try {
          CheckFrame(exposure.image, sensor_model(), kName);
        } catch (const DeviceError& error) {
          FailRead(error.cause(), false);
        }
        return exposure;
      }
    }
    if (now >= deadline) break;
    station_->Advance(std::min<SimStation::Time>(kTick, deadline - now));
  }
  // Whatever still comes of this trigger is stale and will not be taken for the next frame.
  used_triggers_ = triggers();
  FailRead("no frame came within " + std::to_string(timeout.count()) + " ms", true);
}

void SimRangefinder::Disarm() noexcept {
  const std::lock_guard lock(mutex_);
  if (state_ == DeviceState::kArmed) state_ = DeviceState::kIdle;
  station_->SetEmission(false);
}

void SimRangefinder::Reset() {
  CheckAnswers("reset");
  station_->Advance(station_->options().reply_time);
  station_->SetEmission(false);
  const std::lock_guard lock(mutex_);
  state_ = DeviceState::kIdle;
  fault_text_.clear();
}

}  // namespace geond::sim
