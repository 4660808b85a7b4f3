// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sim/fake_gpio_chip.h"

namespace geond::sim {

// While it lives, /dev/gpiochip90 of this process is `chip`: the system calls that libgpiod makes reach it.
class MountedGpioChip {
 public:
  explicit MountedGpioChip(FakeGpioChip& chip);
  ~MountedGpioChip();
  static constexpr char kPath[] = "/dev/gpiochip90";
};

}  // namespace geond::sim
