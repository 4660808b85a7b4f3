// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "core/range/range_image.h"

namespace geond::daemon {

// One exposure as bytes, to the bit, with a sum over all of it.
std::string EncodeExposure(const Exposure& exposure);
// Throws FileError naming `name` and the byte if they are not whole.
Exposure DecodeExposure(std::string_view bytes, const std::string& name);

}  // namespace geond::daemon
