// SPDX-License-Identifier: Apache-2.0
// Compiled for this instruction set alone (core/CMakeLists.txt) and called only on machines that have it.
#if defined(__AVX2__)
#include "core/charge/kernels_body.h"

namespace geond::charge {

extern const Kernels kAvx2Kernels;
const Kernels kAvx2Kernels = MakeKernels("avx2");

}  // namespace geond::charge
#endif
