// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <stop_token>
#include <string_view>

#include "core/base/error.h"

namespace geond {

// Told when a step begins (done = 0) and as it goes on (0 <= done <= total; total = 0: length unknown). Called on the
// thread that does the work; must be quick.
using StepObserver = std::function<void(std::string_view step, int done, int total)>;

// Throws Cancelled if a stop was asked for.
inline void ThrowIfStopped(const std::stop_token& stop) {
  if (stop.stop_requested()) throw Cancelled();
}

}  // namespace geond
