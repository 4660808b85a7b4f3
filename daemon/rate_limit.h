// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <chrono>

namespace geond::daemon {

// Lets so many things a second pass, and twice as many at once after a rest.
class RateLimit {
 public:
  using Time = std::chrono::steady_clock::time_point;
  // `per_second` 0: no limit. A change takes effect at once.
  bool Allows(double per_second, Time now) {
    if (per_second <= 0.0) return true;
    const double most = 2.0 * per_second;
    left_ = started_ ? std::min(most, left_ + per_second * std::chrono::duration<double>(now - last_).count()) : most;
    started_ = true;
    last_ = now;
    if (left_ < 1.0) return false;
    left_ -= 1.0;
    return true;
  }

 private:
  bool started_ = false;
  double left_ = 0.0;
  Time last_{};
};

}  // namespace geond::daemon
