// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <deque>

namespace geond::sim {

struct TurntableOptions {
  double max_speed = 1.0;            // rad/s
  double acceleration = 2.0;         // rad/s^2, also of braking
  double backlash = 0.0005;          // rad the motor turns before the table follows, when the direction changes
  double step = 0.0;                 // rad: the motor stands at whole multiples of it only; 0: anywhere
  double angle_noise = 0.0001;       // rad, standard deviation of a reading
  double angle_resolution = 0.0001;  // rad a count; 0: not rounded
};

// A motor that follows trapezoidal speed profiles, and the table it drives through a gear with backlash, at any moment
// of a clock that only goes forward. Angles in rad, counter-clockwise seen from above, not wrapped.
class TurntableMotion {
 public:
  using Time = std::chrono::nanoseconds;

  explicit TurntableMotion(const TurntableOptions& options, double angle = 0.0);

  // From the present angle and speed to standing at `target`.
  void MoveTo(double target, Time now);
  // Brakes with the given acceleration (rad/s^2; 0: the options') and stands; never softer than it already brakes.
  void Stop(Time now, double braking = 0.0);
  // Puts the motor there at once, as one that something else turns.
  void Place(double angle);
  // Lets time pass. Throws std::invalid_argument if it goes back.
  void Update(Time now);

  double motor_angle() const { return motor_; }
  double table_angle() const { return table_; }  // where the object is
  double speed() const { return speed_; }        // of the motor, rad/s
  bool moving() const { return !phases_.empty(); }

  // Seconds that a move of `angle` (rad) takes from standing to standing.
  static double Duration(const TurntableOptions& options, double angle);

 private:
  struct Phase {
    double duration;  // s
    double rate;      // rad/s^2
  };
  void Follow();

  TurntableOptions options_;
  Time now_{0};
  double motor_, table_;
  double speed_ = 0.0;
  double goal_ = 0.0;         // where the last phase ends
  std::deque<Phase> phases_;  // still to come; of the first the rest
  double braking_ = 0.0;      // rad/s^2 while stopping, else 0
};

}  // namespace geond::sim
