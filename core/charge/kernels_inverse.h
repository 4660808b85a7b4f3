// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <vector>

#include "core/charge/kernels_loops.h"

// The elimination of the local problems in packs (kernels.h says what it does). Internal linkage as in lanes.h.
namespace geond::charge {
namespace {

// For each of kRows rows, row -= sum over t of factor[t] pivots[t] from column begin to end, for kPivots pivots.
template <int kRows, int kPivots>
inline void SubtractPivots(float* const* rows, const float (*factor)[kPivots], const float* const* pivots, int begin,
                           int end) {
  FloatPack minus[kRows][kPivots];
  for (int r = 0; r < kRows; ++r) {
    for (int t = 0; t < kPivots; ++t) minus[r][t] = FloatPack{} - factor[r][t];
  }
  for (int j = begin; j < end; j += kFloats) {
    FloatPack pivot[kPivots];
    for (int t = 0; t < kPivots; ++t) pivot[t] = Load<FloatPack>(pivots[t] + j);
    for (int r = 0; r < kRows; ++r) {
      FloatPack value = Load<FloatPack>(rows[r] + j);
      for (int t = 0; t < kPivots; ++t) value = MultiplyAdd(pivot[t], minus[r][t], value);
      Store(rows[r] + j, value);
    }
  }
}

// Row k of the solutions, kPacks packs from column `at` on, from those of the rows below; `by` is row k of the
// triangle, with the inverse of its pivot.
template <int kPacks>
inline void SolveRow(float* M, const float* by, int k, int m, int width, int at) {
  FloatPack even[kPacks] = {}, odd[kPacks] = {};
  const float* below = M + static_cast<std::ptrdiff_t>(k + 1) * width + at;
  int j = k + 1;
  for (; j + 2 <= m; j += 2, below += 2 * width) {
    for (int p = 0; p < kPacks; ++p) even[p] = MultiplyAdd(Load<FloatPack>(below + p * kFloats), by[j], even[p]);
    for (int p = 0; p < kPacks; ++p)
      odd[p] = MultiplyAdd(Load<FloatPack>(below + width + p * kFloats), by[j + 1], odd[p]);
  }
  if (j < m) {
    for (int p = 0; p < kPacks; ++p) even[p] = MultiplyAdd(Load<FloatPack>(below + p * kFloats), by[j], even[p]);
  }
  float* const row = M + static_cast<std::ptrdiff_t>(k) * width + at;
  for (int p = 0; p < kPacks; ++p) {
    Store(row + p * kFloats, (Load<FloatPack>(row + p * kFloats) - (even[p] + odd[p])) * by[k]);
  }
}

bool InverseRows(float* M, int m, int own, int width, float* rows) {
  constexpr int kPivots = 4,
                kRows = 4;   // taken together, so that a row is loaded once for all pivots and they for all rows
  const int halo = m - own;  // rows before have no right-hand side yet
  const auto row = [&](int i) { return M + static_cast<std::ptrdiff_t>(i) * width; };
  for (int first = 0; first < m; first += kPivots) {
    const int last = std::min(m, first + kPivots), end = last <= halo ? m : m + own;
    const float* pivots[kPivots];
    float inverse[kPivots], factor[kRows][kPivots];
    for (int k = first; k < last; ++k) {
      float* const one_row[] = {row(k)};
      for (int t = first; t < k; ++t) {
        const float one[1][1] = {{row(k)[t] * inverse[t - first]}};
        SubtractPivots<1, 1>(one_row, one, &pivots[t - first], t / kFloats * kFloats, end);
      }
      pivots[k - first] = row(k);
      if (!(std::fabs(row(k)[k]) > 1e-30f)) return false;
      inverse[k - first] = 1.0f / row(k)[k];
    }
    // What stands left of the pivots in their pack is spoilt and not needed any more.
    const int begin = last / kFloats * kFloats;
    for (int i = last; i < m;) {
      const int some = i + kRows <= m ? kRows : 1;  // only whole blocks of pivots have rows below
      float* those[kRows];
      for (int r = 0; r < some; ++r) {
        those[r] = row(i + r);
        for (int t = first; t < last; ++t) {
          float value = those[r][t];
          for (int u = first; u < t; ++u) value -= factor[r][u - first] * pivots[u - first][t];
          factor[r][t - first] = value * inverse[t - first];
        }
      }
      if (some == kRows) {
        SubtractPivots<kRows, kPivots>(those, factor, pivots, begin, end);
      } else {
        SubtractPivots<1, kPivots>(those, factor, pivots, begin, end);
      }
      i += some;
    }
    for (int k = first; k < last; ++k) row(k)[k] = inverse[k - first];
  }
  // The right-hand sides stand behind the matrix, from a whole pack on: its last columns are kept aside where they
  // share it.
  const int begin = m / kFloats * kFloats, end = begin + (m + own - begin + kFloats - 1) / kFloats * kFloats;
  std::vector<float> solved_by(m);
  for (int k = m - 1; k >= 0; --k) {
    std::memcpy(solved_by.data() + k, row(k) + k, (m - k) * sizeof(float));
    int at = begin;
    for (; at + 2 * kFloats <= end; at += 2 * kFloats) SolveRow<2>(M, solved_by.data(), k, m, width, at);
    if (at < end) SolveRow<1>(M, solved_by.data(), k, m, width, at);
    for (int a = 0; a < own; ++a) rows[static_cast<std::ptrdiff_t>(k) * own + a] = row(k)[m + a];
  }
  return true;
}

}  // namespace
}  // namespace geond::charge
