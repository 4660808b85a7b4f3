// SPDX-License-Identifier: Apache-2.0
// Compiled for this instruction set alone (core/CMakeLists.txt) and called only on machines that have it.
#if defined(__AVX512F__) && defined(__AVX512DQ__)
#include "core/geon/misfit_kernel.h"

namespace geond::lanes {

constinit const Loops kAvx512Loops = MakeLoops();

}  // namespace geond::lanes
#endif
