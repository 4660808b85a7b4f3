// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <optional>

#include "core/range/range_image.h"
#include "drivers/u3v_stream.h"

namespace geond::drivers::u3v {

// How the camera's numbers C become depth: (C * scale + offset) * metres, none where C is `invalid`.
struct DepthScale {
  double scale = 1.0, offset = 0.0;
  double metres = 0.001;  // in the camera's unit of distance
  std::optional<double> invalid;
};

// Depths in metres that an image may have, mostly; any by default.
struct DepthRange {
  double least = 0.0, greatest = std::numeric_limits<double>::infinity();
};

// The depth image of a frame that breaks no rule of the transport, with as many rows as were sent. Not finite and not
// positive depths are NaN too. Throws DeviceError if most depths lie outside `range`: an image of nothing.
RangeImage DecodeDepth(const Frame& frame, const DepthScale& scale, const DepthRange& range = {});

}  // namespace geond::drivers::u3v
