// SPDX-License-Identifier: Apache-2.0
#include "sim/fake_bench.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

namespace geond::sim {
namespace {

using std::chrono::milliseconds;

constexpr double kStepsPerTurn = 36000.0;  // of the drive
constexpr milliseconds kTick(1);
constexpr milliseconds kSlowCall(500), kLateInput(1000), kLateFrame(3000);
constexpr int kSlowness = 20;
constexpr int kAlways = std::numeric_limits<int>::max();

WireFault DriveFault(Fault fault) {
  switch (fault) {
    case Fault::kNone:
      return WireFault::kNone;
    case Fault::kOff:
      return WireFault::kOff;
    case Fault::kStuck:
      return WireFault::kStuck;
    case Fault::kGarbage:
      return WireFault::kGarbage;
    case Fault::kWrong:
      return WireFault::kWrong;
    case Fault::kSlow:
      return WireFault::kCrawling;
    case Fault::kDelayed:
      return WireFault::kDelayed;
    case Fault::kIntermittent:
      return WireFault::kIntermittent;
  }
  return WireFault::kNone;
}

FakeCameraFaults CameraFaults(Fault fault, milliseconds exposure) {
  FakeCameraFaults faults;
  if (fault == Fault::kStuck) faults.lost_frames = kAlways;
  if (fault == Fault::kGarbage) faults.bad_leaders = kAlways;
  if (fault == Fault::kWrong) faults.half_images = kAlways;
  if (fault == Fault::kSlow) faults.frame_delay = kSlowness * exposure;
  if (fault == Fault::kDelayed) faults.frame_delay = kLateFrame;
  faults.every_second_lost = fault == Fault::kIntermittent;
  return faults;
}

milliseconds ExposureTime(const SimStation& world) {
  return std::chrono::duration_cast<milliseconds>(world.options().exposure_time);
}

}  // namespace

FakeBench::FakeBench(std::shared_ptr<SimStation> world, FakeDriveOptions drive_line, FakeDrive::Transport transport)
    : world_(std::move(world)),
      radians_per_step_(world_->options().turntable.step > 0.0 ? world_->options().turntable.step
                                                               : 2.0 * std::numbers::pi / kStepsPerTurn),
      chip_(kBenchLines, "fake bench") {
  chip_.SetNames(kBenchLineNames);
  chip_.SetInput(kStopLine, true);
  chip_.SetInput(kDoorLine, true);
  drive_line.position = std::round(world_->motor_angle() / radians_per_step_);
  drive_ = std::make_unique<FakeDrive>(transport, drive_line);
  camera_ = std::make_shared<FakeCamera>(world_->options().assumed.sensor, [this]() -> std::optional<RangeImage> {
    {
      const std::lock_guard lock(mutex_);
      Synchronise();
      if (!world_->laser_line() || world_->emergency_stop() || world_->door_open()) return std::nullopt;
    }
    return world_->TakeImage();
  });
  camera_->SetExposureTime(ExposureTime(*world_));
  plug_ = [this](bool in) { camera_->SetPlugged(in); };
  ticker_ = std::jthread([this](std::stop_token stop) {
    while (!stop.stop_requested()) {
      Tick();
      std::this_thread::sleep_for(kTick);
    }
  });
}

FakeBench::~FakeBench() {
  ticker_ = {};
  camera_->SetPlugged(false);
}

void FakeBench::OnPlug(std::function<void(bool)> plug) { plug_ = std::move(plug); }

// The camera's lock is taken before this bench's, never after it.
void FakeBench::Tick() {
  int pulses = 0;
  {
    const std::lock_guard lock(mutex_);
    Synchronise();
    pulses = std::exchange(triggers_, chip_.rises(kTriggerLine));
    pulses = triggers_ - pulses;
  }
  for (; pulses > 0; --pulses) camera_->WireTrigger();
  world_->SetEmission(camera_->acquiring());
  const std::lock_guard lock(mutex_);
  Note(world_->laser_emits(), drive_->moving());
}

void FakeBench::Synchronise() {
  world_->SetLaserLine(chip_.level(kLaserLine));
  world_->SetMotorLine(chip_.level(kMotorLine));
  world_->SetLampLine(chip_.level(kLampLine));
  drive_->SetPower(bridged_ || world_->motor_powered());
  world_->PlaceMotor(drive_->position() * radians_per_step_);
  if (lines_fault_ == Fault::kDelayed && Clock::now() - inputs_changed_ < kLateInput) return;
  stop_shown_ = world_->emergency_stop();
  door_shown_ = world_->door_open();
  const bool inverted = lines_fault_ == Fault::kWrong;
  if (lines_fault_ == Fault::kGarbage) chatter_ = !chatter_;
  const bool chatters = lines_fault_ == Fault::kGarbage && chatter_;
  chip_.SetInput(kStopLine, (stop_shown_ != inverted) == chatters);
  chip_.SetInput(kDoorLine, door_shown_ == inverted);
}

void FakeBench::Note(bool shines, bool turns) {
  const Clock::time_point now = Clock::now();
  if (shines != std::exchange(shines_, shines)) {
    events_.push_back({shines ? BenchEvent::Kind::kLaserOn : BenchEvent::Kind::kLaserOff, now});
  }
  if (turns != std::exchange(turns_, turns)) {
    events_.push_back({turns ? BenchEvent::Kind::kMotionBegins : BenchEvent::Kind::kMotionEnds, now});
  }
}

void FakeBench::SetFault(Device device, Fault fault) {
  if (device == Device::kTurntable) return drive_->SetFault(DriveFault(fault));
  if (device == Device::kRangefinder) {
    if (camera_->plugged() != (fault != Fault::kOff)) plug_(fault != Fault::kOff);
    return camera_->SetFaults(CameraFaults(fault, ExposureTime(*world_)));
  }
  chip_.SetStuck(fault == Fault::kStuck);
  chip_.SetSlow(fault == Fault::kSlow ? kSlowCall : milliseconds(0));
  chip_.SetIntermittent(fault == Fault::kIntermittent);
  if (fault == Fault::kOff) {
    chip_.Unplug();
  } else {
    chip_.PlugIn();
  }
  const std::lock_guard lock(mutex_);
  lines_fault_ = fault;
}

void FakeBench::SetEmergencyStop(bool pressed) {
  const std::lock_guard lock(mutex_);
  inputs_changed_ = Clock::now();
  world_->SetEmergencyStop(pressed);
}

void FakeBench::SetDoorOpen(bool open) {
  const std::lock_guard lock(mutex_);
  inputs_changed_ = Clock::now();
  world_->SetDoorOpen(open);
}

void FakeBench::BridgeMotorContact(bool bridged) {
  const std::lock_guard lock(mutex_);
  bridged_ = bridged;
}

bool FakeBench::laser_shines() const {
  const std::lock_guard lock(mutex_);
  return shines_;
}

bool FakeBench::table_turns() const {
  const std::lock_guard lock(mutex_);
  return turns_;
}

std::vector<BenchEvent> FakeBench::TakeEvents() {
  const std::lock_guard lock(mutex_);
  return std::exchange(events_, {});
}

}  // namespace geond::sim
