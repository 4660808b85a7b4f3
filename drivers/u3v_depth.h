// SPDX-License-Identifier: Apache-2.0
#pragma once

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

// The depth image of a frame that breaks no rule of the transport, with as many rows as were sent. Not finite and not
// positive depths are NaN too.
RangeImage DecodeDepth(const Frame& frame, const DepthScale& scale);

}  // namespace geond::drivers::u3v
