// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <mutex>
#include <utility>

#include "drivers/rangefinder.h"

namespace geond::drivers {

// One listener that several threads may tell. Once Set has returned, the listener before it is not running any more.
class FaultSignal {
 public:
  void Set(FaultListener listener) {
    const std::lock_guard lock(mutex_);
    listener_ = std::move(listener);
  }
  void Tell() {
    const std::lock_guard lock(mutex_);
    if (listener_) listener_();
  }

 private:
  std::mutex mutex_;
  FaultListener listener_;
};

}  // namespace geond::drivers
