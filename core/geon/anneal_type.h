// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <stop_token>

#include "core/geon/fit_data.h"
#include "core/geon/refine.h"
#include "core/geon/vfsr.h"

namespace geond {

// One type fitted by annealing alone, as the thesis does: E at `lambda` over the parameters of Table 5.2 with its bounds as
// corrected (room for strong bends and for centres beyond a quarter of the diagonal). Throws Cancelled.
RefineResult AnnealType(GeonType type, const FitData& data, double lambda, std::uint64_t seed, const VfsrOptions& options,
                        std::stop_token stop);

}  // namespace geond
