// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "sim/fake_camera.h"

namespace geond::sim {

// Shows a fake camera to other programs as a device on a USB port, through umockdev: the programs need no change and
// the kernel no module, their system calls are answered here. They see it if libumockdev-preload.so.0 is preloaded and
// UMOCKDEV_DIR names folder(). One a program; plugged in at first.
class FakeUsbPort {
 public:
  explicit FakeUsbPort(FakeCamera& camera);
  ~FakeUsbPort();
  FakeUsbPort(const FakeUsbPort&) = delete;
  FakeUsbPort& operator=(const FakeUsbPort&) = delete;

  void Plug();
  void Unplug();
  std::string folder() const;
  static constexpr char kPreload[] = "libumockdev-preload.so.0";

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace geond::sim
