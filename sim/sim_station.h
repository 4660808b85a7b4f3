// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <vector>

#include "core/range/range_image.h"
#include "core/range/scan_folder.h"
#include "sim/fault.h"
#include "sim/range_camera.h"
#include "sim/scene.h"
#include "sim/turntable_motion.h"

namespace geond::sim {

// How the true turntable stands in the assumed one: its axis is tilted and beside the calibrated axis.
struct AxisError {
  double tilt = 0.0017;  // rad, about a horizontal line at tilt_azimuth (rad from x of T)
  double tilt_azimuth = 0.7;
  double offset_x = 0.0001;   // m
  double offset_y = -0.0001;  // m
};
// X_TwTt: pose of the true turntable frame in the one that the calibration assumes.
Pose AxisErrorPose(const AxisError& error);

// How the true rangefinder departs from the assumed sensor model.
struct SensorError {
  double depth_scale = 0.0;   // depth is read as depth * (1 + depth_scale) + depth_offset
  double depth_offset = 0.0;  // m
  double focal = 0.0;         // the true focal lengths are the assumed ones times 1 + focal
};

struct StationOptions {
  StationGeometry assumed = MakeStation();  // what calibration believes
  AxisError axis_error;
  SensorError sensor_error;
  CameraOptions camera;
  TurntableOptions turntable;
  std::chrono::nanoseconds exposure_time = std::chrono::milliseconds(40);  // from trigger to frame
  std::chrono::nanoseconds reply_time = std::chrono::milliseconds(2);      // of drive and wires
  std::chrono::nanoseconds homing_time = std::chrono::seconds(2);
  std::chrono::nanoseconds motion_time_limit = std::chrono::seconds(20);  // longer than this a move has failed
  double real_time_factor = 0.0;  // real seconds that a simulated second takes; 0: none, nothing ever sleeps
  std::uint64_t seed = 1;
  int threads = 0;
};

// The world that the three simulated devices share: scene, clock, table, wires, people and faults. Safe from any
// thread. Time is simulated: it passes only when a device waits (Advance).
class SimStation {
 public:
  using Time = std::chrono::nanoseconds;

  // Throws std::invalid_argument if scene or options are impossible.
  SimStation(const Scene& scene, const StationOptions& options);
  ~SimStation();
  SimStation(const SimStation&) = delete;
  SimStation& operator=(const SimStation&) = delete;

  const StationOptions& options() const { return options_; }
  Scene scene() const;
  // Puts something else on the table. Throws std::invalid_argument if the scene is impossible.
  void SetScene(const Scene& scene);

  // --- time
  Time now() const;
  // Lets simulated time pass, running on its way what was scheduled; sleeps only if real_time_factor > 0.
  void Advance(Time duration);
  // Runs `action` on the advancing thread once the clock passes now() + delay.
  void Schedule(Time delay, std::function<void()> action);

  // --- faults and people
  // From now on, until set again; Fault::kNone mends the device. The one switch for all faults.
  void SetFault(Device device, Fault fault);
  Fault fault(Device device) const;
  void SetEmergencyStop(bool pressed);
  void SetDoorOpen(bool open);
  bool emergency_stop() const;
  bool door_open() const;
  // Told (on whatever thread) when one of the two changes; nullptr: nobody.
  void OnInputChange(std::function<void()> listener);

  // --- wires, as the hardware has them: the emergency stop cuts motor power and laser, an open door the laser
  void SetLaserLine(bool on);
  void SetMotorLine(bool on);
  void SetLampLine(bool on);
  void SetEmission(bool on);  // the rangefinder's own switch, in series with the wire
  bool laser_line() const;
  bool motor_line() const;
  bool lamp_line() const;
  bool laser_emits() const;
  bool motor_powered() const;

  // --- the trigger wire
  void PulseTrigger();
  std::uint64_t trigger_count() const;
  Time last_trigger() const;

  // --- the table
  void MoveTable(double target);
  void StopTable(double braking = 0.0);
  void PlaceMotor(double angle);  // by a drive that is simulated elsewhere
  double motor_angle() const;
  double table_angle() const;  // true, of the object
  bool table_moving() const;
  double ReadAngle();  // as the encoder says it: noise and resolution

  // The true pose of the sensor in T now, and a range image taken from there (the laser's state does not matter here).
  Pose TrueSensorPose() const;
  RangeImage TakeImage();

 private:
  void UpdateTo(Time time);  // mutex held
  void CutPowerIfNeeded();   // mutex held

  const StationOptions options_;
  SensorModel true_sensor_;
  mutable std::mutex mutex_;
  Scene scene_;
  std::shared_ptr<const SceneGeometry> geometry_;
  Time now_{0};
  std::multimap<Time, std::function<void()>> scheduled_;
  std::map<Device, Fault> faults_;
  std::function<void()> on_input_change_;
  bool emergency_stop_ = false, door_open_ = false;
  bool laser_line_ = false, motor_line_ = false, lamp_line_ = false, emission_ = false;
  TurntableMotion motion_;
  std::uint64_t triggers_ = 0, readings_ = 0, frames_ = 0;
  Time last_trigger_{0};
};

}  // namespace geond::sim
