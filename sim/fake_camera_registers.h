// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

#include "drivers/u3v_protocol.h"

// Where the fake camera keeps what; the first four as every U3V compatible camera has them.
namespace geond::sim::fake_camera {

inline constexpr std::uint64_t kTransport = 0x10000, kStream = 0x20000, kManifest = 0x30000, kDescription = 0x40000;
inline constexpr std::uint64_t kFeatures = 0x100000, kMemoryEnd = 0x101000;
// From kFeatures; 4 bytes each, the floating-point ones 8.
inline constexpr std::uint64_t kWidth = 0x00, kHeight = 0x04, kPixelFormat = 0x08, kAcquisition = 0x0c,
                               kAcquisitionMode = 0x10, kTriggerMode = 0x14, kTriggerSource = 0x18,
                               kTriggerSoftware = 0x1c, kPayloadSize = 0x20, kExposureTicks = 0x24, kLocked = 0x28,
                               kTriggerActivation = 0x2c, kTriggerSelector = 0x30, kDistanceUnit = 0x34, kScale = 0x40,
                               kOffset = 0x48, kInvalidValue = 0x50, kInvalidFlag = 0x58, kFocalLength = 0x60,
                               kPrincipalU = 0x68, kPrincipalV = 0x70, kAxisMin = 0x78, kAxisMax = 0x80;

inline constexpr double kUnitsPerMetre16 = 50'000.0;  // of formats of whole numbers: 0.02 mm a step
inline constexpr std::size_t kChunkBytes = 24;  // behind an image: id and length of it, a time, id and length of that

inline bool IsWholeNumber(std::uint64_t pixel_format) {
  return pixel_format == static_cast<std::uint64_t>(drivers::u3v::PixelFormat::kCoord3dC16) ||
         pixel_format == static_cast<std::uint64_t>(drivers::u3v::PixelFormat::kCoord3dAbc16);
}

// Counts a fault that is to happen so many times more down; whether it does now.
inline bool TakeOne(int& count) { return count > 0 && count-- > 0; }

}  // namespace geond::sim::fake_camera
