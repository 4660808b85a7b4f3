// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string>

namespace geond::drivers {

// The contents of the first file of a zip archive (stored or deflated). Throws DeviceError if it is broken or larger
// than 64 MiB.
std::string UnzipFirstFile(std::span<const std::uint8_t> archive);

}  // namespace geond::drivers
