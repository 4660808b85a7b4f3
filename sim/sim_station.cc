// SPDX-License-Identifier: Apache-2.0
#include "sim/sim_station.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <thread>
#include <utility>

#include "sim/random.h"

namespace geond::sim {
namespace {

constexpr double kPowerOffBraking = 20.0;  // rad/s^2: friction and the brake of an unpowered motor
constexpr std::uint64_t kEncoderStream = 0x656e636f64657200u;

}  // namespace

Pose AxisErrorPose(const AxisError& error) {
  const Eigen::Vector3d line(std::cos(error.tilt_azimuth), std::sin(error.tilt_azimuth), 0.0);
  return Pose::Translation({error.offset_x, error.offset_y, 0.0}) * Pose::Rotation(line, error.tilt);
}

SimStation::SimStation(const Scene& scene, const StationOptions& options)
    : options_(options),
      true_sensor_(options.assumed.sensor),
      scene_(scene),
      geometry_(std::make_shared<const SceneGeometry>(scene)),
      motion_(options.turntable, 0.4) {
  if (!(options.real_time_factor >= 0.0)) throw std::invalid_argument("SimStation: real_time_factor must be 0 or more");
  true_sensor_.focal_u *= 1.0 + options.sensor_error.focal;
  true_sensor_.focal_v *= 1.0 + options.sensor_error.focal;
}

SimStation::~SimStation() = default;

Scene SimStation::scene() const {
  const std::lock_guard lock(mutex_);
  return scene_;
}

void SimStation::SetScene(const Scene& scene) {
  auto geometry = std::make_shared<const SceneGeometry>(scene);
  const std::lock_guard lock(mutex_);
  scene_ = scene;
  geometry_ = std::move(geometry);
}

SimStation::Time SimStation::now() const {
  const std::lock_guard lock(mutex_);
  return now_;
}

void SimStation::UpdateTo(Time time) {
  now_ = std::max(now_, time);
  motion_.Update(now_);
}

void SimStation::Advance(Time duration) {
  if (duration <= Time::zero()) return;
  if (options_.real_time_factor > 0.0) std::this_thread::sleep_for(duration * options_.real_time_factor);
  std::unique_lock lock(mutex_);
  const Time end = now_ + duration;
  while (!scheduled_.empty() && scheduled_.begin()->first <= end) {
    const auto next = scheduled_.extract(scheduled_.begin());
    UpdateTo(next.key());
    lock.unlock();
    next.mapped()();
    lock.lock();
  }
  UpdateTo(end);
}

void SimStation::Schedule(Time delay, std::function<void()> action) {
  const std::lock_guard lock(mutex_);
  scheduled_.emplace(now_ + std::max(delay, Time::zero()), std::move(action));
}

void SimStation::SetFault(Device device, Fault fault) {
  const std::lock_guard lock(mutex_);
  faults_[device] = fault;
  if (device == Device::kLines && fault == Fault::kOff) {
    // The chip is gone and its outputs are released: everything they hold is off.
    laser_line_ = motor_line_ = lamp_line_ = false;
    CutPowerIfNeeded();
  }
}

Fault SimStation::fault(Device device) const {
  const std::lock_guard lock(mutex_);
  const auto found = faults_.find(device);
  return found == faults_.end() ? Fault::kNone : found->second;
}

void SimStation::SetEmergencyStop(bool pressed) {
  std::function<void()> listener;
  {
    const std::lock_guard lock(mutex_);
    emergency_stop_ = pressed;
    CutPowerIfNeeded();
    listener = on_input_change_;
  }
  if (listener) listener();
}

void SimStation::SetDoorOpen(bool open) {
  std::function<void()> listener;
  {
    const std::lock_guard lock(mutex_);
    door_open_ = open;
    listener = on_input_change_;
  }
  if (listener) listener();
}

bool SimStation::emergency_stop() const {
  const std::lock_guard lock(mutex_);
  return emergency_stop_;
}

bool SimStation::door_open() const {
  const std::lock_guard lock(mutex_);
  return door_open_;
}

void SimStation::OnInputChange(std::function<void()> listener) {
  const std::lock_guard lock(mutex_);
  on_input_change_ = std::move(listener);
}

void SimStation::CutPowerIfNeeded() {
  if (emergency_stop_ || !motor_line_) motion_.Stop(now_, kPowerOffBraking);
}

void SimStation::SetLaserLine(bool on) {
  const std::lock_guard lock(mutex_);
  laser_line_ = on;
}

void SimStation::SetMotorLine(bool on) {
  const std::lock_guard lock(mutex_);
  motor_line_ = on;
  CutPowerIfNeeded();
}

void SimStation::SetLampLine(bool on) {
  const std::lock_guard lock(mutex_);
  lamp_line_ = on;
}

void SimStation::SetEmission(bool on) {
  const std::lock_guard lock(mutex_);
  emission_ = on;
}

bool SimStation::laser_line() const {
  const std::lock_guard lock(mutex_);
  return laser_line_;
}

bool SimStation::motor_line() const {
  const std::lock_guard lock(mutex_);
  return motor_line_;
}

bool SimStation::lamp_line() const {
  const std::lock_guard lock(mutex_);
  return lamp_line_;
}

bool SimStation::laser_emits() const {
  const std::lock_guard lock(mutex_);
  return laser_line_ && emission_ && !emergency_stop_ && !door_open_;
}

bool SimStation::motor_powered() const {
  const std::lock_guard lock(mutex_);
  return motor_line_ && !emergency_stop_;
}

void SimStation::PulseTrigger() {
  const std::lock_guard lock(mutex_);
  ++triggers_;
  last_trigger_ = now_;
}

std::uint64_t SimStation::trigger_count() const {
  const std::lock_guard lock(mutex_);
  return triggers_;
}

SimStation::Time SimStation::last_trigger() const {
  const std::lock_guard lock(mutex_);
  return last_trigger_;
}

void SimStation::MoveTable(double target) {
  const std::lock_guard lock(mutex_);
  if (motor_line_ && !emergency_stop_) motion_.MoveTo(target, now_);
}

void SimStation::StopTable(double braking) {
  const std::lock_guard lock(mutex_);
  motion_.Stop(now_, braking);
}

void SimStation::PlaceMotor(double angle) {
  const std::lock_guard lock(mutex_);
  motion_.Place(angle);
}

double SimStation::motor_angle() const {
  const std::lock_guard lock(mutex_);
  return motion_.motor_angle();
}

double SimStation::table_angle() const {
  const std::lock_guard lock(mutex_);
  return motion_.table_angle();
}

bool SimStation::table_moving() const {
  const std::lock_guard lock(mutex_);
  return motion_.moving();
}

double SimStation::ReadAngle() {
  const std::lock_guard lock(mutex_);
  CounterRandom random(options_.seed, kEncoderStream, readings_++);
  const double angle = motion_.motor_angle() + options_.turntable.angle_noise * random.Normal();
  const double count = options_.turntable.angle_resolution;
  return count > 0.0 ? std::round(angle / count) * count : angle;
}

Pose SimStation::TrueSensorPose() const {
  StationGeometry truth = options_.assumed;
  truth.X_WT = options_.assumed.X_WT * AxisErrorPose(options_.axis_error);
  return SensorInTurntable(truth, table_angle());
}

RangeImage SimStation::TakeImage() {
  std::uint64_t frame;
  std::shared_ptr<const SceneGeometry> geometry;
  {
    const std::lock_guard lock(mutex_);
    frame = frames_++;
    geometry = geometry_;
  }
  RangeImage image =
      TakeRangeImage(*geometry, true_sensor_, TrueSensorPose(), options_.camera, options_.seed, frame, options_.threads);
  const SensorError& error = options_.sensor_error;
  if (error.depth_scale != 0.0 || error.depth_offset != 0.0) {
    for (float& depth : image.depth) depth = static_cast<float>(depth * (1.0 + error.depth_scale) + error.depth_offset);
  }
  return image;
}

}  // namespace geond::sim
