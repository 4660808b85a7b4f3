// SPDX-License-Identifier: Apache-2.0
#include "sim/turntable_motion.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace geond::sim {

TurntableMotion::TurntableMotion(const TurntableOptions& options, double angle)
    : options_(options), motor_(angle), table_(angle) {
  if (!(options.max_speed > 0.0) || !(options.acceleration > 0.0) || !(options.backlash >= 0.0)) {
    throw std::invalid_argument("TurntableMotion: speed and acceleration must be positive, backlash 0 or more");
  }
}

// Brakes to a stand first if the target is behind or too near to stop at; then speeds up, cruises and brakes so that
// speed and distance reach zero together.
void TurntableMotion::MoveTo(double target, Time now) {
  Update(now);
  phases_.clear();
  braking_ = 0.0;
  if (options_.step > 0.0) target = std::round(target / options_.step) * options_.step;
  goal_ = target;
  const double a = options_.acceleration;
  double from = motor_, speed = speed_;
  const double stand = from + speed * std::abs(speed) / (2.0 * a);
  if (speed * (target - stand) < 0.0) {
    phases_.push_back({std::abs(speed) / a, speed > 0.0 ? -a : a});
    from = stand;
    speed = 0.0;
  }
  const double side = target < from ? -1.0 : 1.0;
  const double d = std::abs(target - from), v = std::abs(speed);
  const double top = std::max(v, std::min(options_.max_speed, std::sqrt(a * d + 0.5 * v * v)));
  if (!(top > 0.0)) return;  // it stands there already
  phases_.push_back({(top - v) / a, side * a});
  phases_.push_back({std::max(0.0, (d - (top * top - 0.5 * v * v) / a) / top), 0.0});
  phases_.push_back({top / a, -side * a});
}

void TurntableMotion::Stop(Time now, double braking) {
  Update(now);
  braking = std::max(braking_, braking > 0.0 ? braking : options_.acceleration);
  if (phases_.empty()) return;
  braking_ = braking;
  phases_.assign(1, {std::abs(speed_) / braking, speed_ > 0.0 ? -braking : braking});
  goal_ = motor_ + speed_ * std::abs(speed_) / (2.0 * braking);
}

void TurntableMotion::Update(Time now) {
  if (now < now_) throw std::invalid_argument("TurntableMotion: time goes back");
  double left = std::chrono::duration<double>(now - now_).count();
  now_ = now;
  while (!phases_.empty()) {
    Phase& phase = phases_.front();
    const bool ends = phase.duration <= left;
    const double time = ends ? phase.duration : left;
    motor_ += speed_ * time + 0.5 * phase.rate * time * time;
    speed_ += phase.rate * time;
    left -= time;
    if (ends && phases_.size() == 1) {  // without what rounding left over
      motor_ = goal_;
      speed_ = 0.0;
      braking_ = 0.0;
    }
    Follow();
    if (!ends) {
      phase.duration -= time;
      return;
    }
    phases_.pop_front();
  }
}

void TurntableMotion::Place(double angle) {
  phases_.clear();
  speed_ = braking_ = 0.0;
  motor_ = goal_ = angle;
  Follow();
}

void TurntableMotion::Follow() {
  const double play = 0.5 * options_.backlash;
  table_ = std::clamp(table_, motor_ - play, motor_ + play);
}

double TurntableMotion::Duration(const TurntableOptions& options, double angle) {
  const double d = std::abs(angle), v = options.max_speed, a = options.acceleration;
  return d * a < v * v ? 2.0 * std::sqrt(d / a) : d / v + v / a;
}

}  // namespace geond::sim
