// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sim/fake_camera.h"

namespace geond::sim {

// What a fake camera is as a USB device, whoever shows it: two interfaces (control, stream) of USB3 Vision.
// Device and configuration descriptor, one behind the other.
std::vector<std::uint8_t> FakeUsbDescriptors();

// A request on endpoint 0: `setup` is its 8 bytes. Bytes of the answer put into `data`, or FakeCamera::kStall.
int FakeUsbControl(FakeCamera& camera, std::span<const std::uint8_t> setup, std::span<std::uint8_t> data);

}  // namespace geond::sim
