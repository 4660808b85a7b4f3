// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace geond {

// What printf would write, as a string.
[[gnu::format(printf, 1, 2)]] std::string Printed(const char* format, ...);

}  // namespace geond
