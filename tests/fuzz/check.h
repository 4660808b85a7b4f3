// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdlib>

// What must hold whatever the input is.
inline void Check(bool holds) {
  if (!holds) std::abort();
}
