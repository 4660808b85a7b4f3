// SPDX-License-Identifier: Apache-2.0
#include "core/charge/kernels_body.h"

namespace geond::charge {

extern const Kernels kBaselineKernels;
const Kernels kBaselineKernels = MakeKernels("baseline");

}  // namespace geond::charge
