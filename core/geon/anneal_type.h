// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <stop_token>
#include <vector>

#include "core/geon/fit_data.h"
#include "core/geon/refine.h"
#include "core/geon/vfsr.h"

namespace geond {

// What annealing works on, in the own frame and unit of the data: ax ay az tx ty tz rx ry rz (turned by Rz Ry Rx), then
// kx ky, or the curvature as a share of the greatest that the sizes allow. The bounds are those of Table 5.2 as corrected
// (room for strong bends and for centres beyond a quarter of the diagonal).
std::vector<VfsrRange> AnnealRanges(GeonType type, const FitData& data);
GeonState AnnealedState(GeonType type, std::span<const double> parameters);

// One type fitted by annealing alone, as the thesis does: E at `lambda` over these parameters.
// Throws Cancelled.
RefineResult AnnealType(GeonType type, const FitData& data, double lambda, std::uint64_t seed, const VfsrOptions& options,
                        std::stop_token stop);

}  // namespace geond
