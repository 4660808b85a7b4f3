// SPDX-License-Identifier: Apache-2.0
#include "core/charge/kernels.h"

#include <array>

namespace geond::charge {

extern const Kernels kBaselineKernels;
#if defined(__x86_64__)
extern const Kernels kAvx2Kernels, kAvx512Kernels;
#endif

std::span<const Kernels* const> UsableKernels() {
#if defined(__x86_64__)
  static const std::array<const Kernels*, 3> all = {&kBaselineKernels, &kAvx2Kernels, &kAvx512Kernels};
  static const std::size_t usable = [] {
    __builtin_cpu_init();
    if (!__builtin_cpu_supports("avx2") || !__builtin_cpu_supports("fma")) return 1;
    return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") ? 3 : 2;
  }();
  return std::span(all).first(usable);
#else
  static const std::array<const Kernels*, 1> all = {&kBaselineKernels};
  return all;
#endif
}

const Kernels& BestKernels() { return *UsableKernels().back(); }

}  // namespace geond::charge
