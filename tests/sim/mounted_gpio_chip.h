// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>

#include "sim/fake_gpio_chip.h"
#include "sim/preload/gpio_system_calls.h"

namespace geond::sim {

// While it lives, a fake chip is this program's chip at kPath. One at a time.
class MountedGpioChip {
 public:
  explicit MountedGpioChip(FakeGpioChip& chip) {
    chip_ = &chip;
    MountGpioChip(
        [](int fd, unsigned long request, void* argument) { return chip_.load()->Ioctl(fd, request, argument); });
  }
  ~MountedGpioChip() { MountGpioChip(nullptr); }
  MountedGpioChip(const MountedGpioChip&) = delete;
  MountedGpioChip& operator=(const MountedGpioChip&) = delete;
  static constexpr const char* kPath = kGpioChipPath;

 private:
  static inline std::atomic<FakeGpioChip*> chip_{nullptr};
};

}  // namespace geond::sim
