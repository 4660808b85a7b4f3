// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "daemon/command/command.h"

namespace geond::daemon {

// A description, as the service answers it, for a person: a line a part, a line a relation.
std::string DescriptionText(const Json& description);

}  // namespace geond::daemon
