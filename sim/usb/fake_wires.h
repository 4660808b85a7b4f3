// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <string>
#include <vector>

#include "sim/fake_bench.h"
#include "sim/fake_gpio_socket.h"
#include "sim/usb/fake_usb_port.h"

namespace geond::sim {

// Starts a program that finds fake devices: `preload` goes before what is preloaded already, `settings` ("NAME=value")
// into its environment. Its output goes to the file `log`, if not empty. Returns its process. Throws FileError.
pid_t StartBelow(const std::vector<std::string>& arguments, const std::string& preload,
                 const std::vector<std::string>& settings, const std::filesystem::path& log);
// Waits for its end: its exit status, or 128 plus the signal that ended it.
int WaitFor(pid_t process);

// Shows a fake bench to other programs: its camera on a USB port, its GPIO chip at /dev/gpiochip90, its drive on a
// serial port at folder/drive. The programs need no change.
class FakeWires {
 public:
  // `folder` must exist. Throws FileError.
  FakeWires(FakeBench& bench, const std::filesystem::path& folder);
  ~FakeWires();
  FakeWires(const FakeWires&) = delete;
  FakeWires& operator=(const FakeWires&) = delete;

  std::filesystem::path serial_device() const { return folder_ / "drive"; }
  pid_t Start(const std::vector<std::string>& arguments, const std::filesystem::path& log = {}) const;

 private:
  FakeBench& bench_;
  const std::filesystem::path folder_;
  FakeGpioSocket gpio_;
  FakeUsbPort usb_;
};

}  // namespace geond::sim
