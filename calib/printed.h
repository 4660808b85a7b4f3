// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace geond::calib {

// A sentence with numbers in it, as printf writes it.
[[gnu::format(printf, 1, 2)]] std::string Printed(const char* format, ...);

}  // namespace geond::calib
