// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <limits>
#include <vector>

#include "core/geon/fit.h"
#include "core/geon/fit_data.h"
#include "core/geon/multi_start.h"

namespace geond {

struct Choice {
  std::size_t chosen = 0;
  double margin = std::numeric_limits<double>::infinity();  // as in GeonFit
  double confidence = 0.0;
};

// Which of the fits, one a type, describes the data: the one of least objective; or, if that is a deformed type and its
// base type is nearly as good, the base type (the deformed shapes contain the straight ones and win by a little on any
// data). "Nearly" is by a ratio, or by what the scatter of the data allows: the difference of the two misfits, summed
// over stretches of eight neighbouring points whose errors are taken as related, against its standard error (Vuong
// 1989).
Choice ChooseType(const std::vector<RefineResult>& found, const FitData& data, const FitOptions& options);

}  // namespace geond
