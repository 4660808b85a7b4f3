// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <thread>

#include "sim/fake_gpio_chip.h"

namespace geond::sim {

// One ioctl as it goes over the socket, and its answer. A new descriptor travels beside the answer.
struct GpioSocketMessage {
  std::uint64_t request = 0;
  std::uint64_t inode = 0;  // of the line's descriptor, 0: the chip's
  std::int32_t result = 0;
  std::uint32_t fd_at = 0;  // where in `data` the new descriptor belongs; 0: there is none
  std::uint8_t data[1024] = {};
};

// Shows a fake chip to other programs, which find it at /dev/gpiochip90 with libfake_gpio.so preloaded and the socket's
// path in GEOND_FAKE_GPIO. Serves on a thread of its own until destroyed.
class FakeGpioSocket {
 public:
  // Throws FileError if the socket cannot be made.
  FakeGpioSocket(FakeGpioChip& chip, const std::string& path);
  ~FakeGpioSocket();
  FakeGpioSocket(const FakeGpioSocket&) = delete;
  FakeGpioSocket& operator=(const FakeGpioSocket&) = delete;

 private:
  void Serve(std::stop_token stop);
  bool Answer(int client);

  FakeGpioChip& chip_;
  const std::string path_;
  int listener_ = -1;
  std::jthread thread_;
};

}  // namespace geond::sim
