// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <mutex>

#include "core/base/error.h"
#include "drivers/rangefinder.h"
#include "drivers/usb_port.h"

namespace geond::drivers {

// Runs one call to a USB device and returns its result. A DeviceError goes on, after `info` says that the device is
// faulted or, if it is unplugged, absent.
template <typename Work>
auto NotingFault(std::mutex& info_mutex, DeviceInfo& info, const Work& work) {
  try {
    return work();
  } catch (const DeviceError& error) {
    const std::lock_guard lock(info_mutex);
    const bool gone = error.cause().find(UsbStatusWords(UsbPort::Status::kGone)) != std::string::npos;
    info.state = gone ? DeviceState::kAbsent : DeviceState::kFault;
    info.fault = error.what();
    throw;
  }
}

}  // namespace geond::drivers
