// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace geond::sim {

// The path of the chip that is not there.
inline constexpr char kGpioChipPath[] = "/dev/gpiochip90";

// Answers an ioctl of the kind that GPIO chips have: its result, or -errno.
using GpioIoctl = int (*)(int fd, unsigned long request, void* argument);

// From now on, until nullptr is given, this program finds a GPIO chip at that path: the system calls that libgpiod
// makes are answered in this program, their ioctls by `answer`.
void MountGpioChip(GpioIoctl answer);

}  // namespace geond::sim
