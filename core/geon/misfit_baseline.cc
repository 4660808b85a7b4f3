// SPDX-License-Identifier: Apache-2.0
// Compiled for any processor of the kind.
#include "core/geon/misfit_kernel.h"

namespace geond::lanes {

constinit const Loops kBaselineLoops = MakeLoops();

}  // namespace geond::lanes
