// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "daemon/command/command.h"

namespace geond::daemon {

// What the later of two descriptions of one object (as JSON) says otherwise than the earlier, in words: number of parts, a
// part's type, or a size that differs by more than both deviations together (2 of them) and 3 % and 0.3 mm. Empty: nothing.
std::string WhatChanged(const Json& before, const Json& after);

}  // namespace geond::daemon
