// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>

#include "core/charge/kernels_loops.h"

// The elimination of the local problems in packs (kernels.h says what it does). Internal linkage as in lanes.h.
namespace geond::charge {
namespace {

// row -= sum over t of factor[t] what[t], from column begin to end, for 1 to 4 rows at once.
template <int kRows>
inline void SubtractRows(float* row, const float* factor, const float* const* what, int begin, int end) {
  for (int j = begin; j < end; j += kFloats) {
    FloatPack value = Load<FloatPack>(row + j);
    for (int t = 0; t < kRows; ++t) value = MultiplyAdd(Load<FloatPack>(what[t] + j), -factor[t], value);
    Store(row + j, value);
  }
}

bool InverseRows(float* M, int m, int own, int width, float* rows) {
  constexpr int kPivots = 4;  // eliminated together, so that a row is loaded once for all of them
  const int halo = m - own;   // rows before have no right-hand side yet
  const auto row = [&](int i) { return M + static_cast<std::ptrdiff_t>(i) * width; };
  for (int first = 0; first < m; first += kPivots) {
    const int last = std::min(m, first + kPivots), end = last <= halo ? m : m + own;
    const float* pivots[kPivots];
    float inverse[kPivots], factor[kPivots];
    for (int k = first; k < last; ++k) {
      for (int t = first; t < k; ++t) {
        const float one = row(k)[t] * inverse[t - first];
        SubtractRows<1>(row(k), &one, &pivots[t - first], t / kFloats * kFloats, end);
      }
      pivots[k - first] = row(k);
      if (!(std::fabs(row(k)[k]) > 1e-30f)) return false;
      inverse[k - first] = 1.0f / row(k)[k];
    }
    for (int i = last; i < m; ++i) {
      for (int t = first; t < last; ++t) {
        float value = row(i)[t];
        for (int u = first; u < t; ++u) value -= factor[u - first] * pivots[u - first][t];
        factor[t - first] = value * inverse[t - first];
      }
      // What stands left of the pivots in their pack is spoilt and not needed any more.
      const int begin = last / kFloats * kFloats;
      if (last - first == kPivots) {
        SubtractRows<kPivots>(row(i), factor, pivots, begin, end);
      } else {
        for (int t = 0; t < last - first; ++t) SubtractRows<1>(row(i), factor + t, pivots + t, begin, end);
      }
    }
    for (int k = first; k < last; ++k) row(k)[k] = inverse[k - first];
  }
  // The right-hand sides stand behind the matrix, from a whole pack on: its last columns are kept aside where they share it.
  const int begin = m / kFloats * kFloats, packs = (m + own - begin + kFloats - 1) / kFloats;
  constexpr int kMostPacks = 4;
  for (int k = m - 1; k >= 0; --k) {
    float kept[kFloats];
    std::memcpy(kept, row(k) + begin, sizeof kept);
    const float inverse = row(k)[k];
    for (int done = 0; done < packs; done += kMostPacks) {
      const int some = std::min(kMostPacks, packs - done), at = begin + done * kFloats;
      FloatPack sum[kMostPacks] = {};
      for (int j = k + 1; j < m; ++j) {
        const float factor = j < begin ? row(k)[j] : kept[j - begin];
        for (int p = 0; p < some; ++p) sum[p] = MultiplyAdd(Load<FloatPack>(row(j) + at + p * kFloats), factor, sum[p]);
      }
      for (int p = 0; p < some; ++p) {
        Store(row(k) + at + p * kFloats, (Load<FloatPack>(row(k) + at + p * kFloats) - sum[p]) * inverse);
      }
    }
    for (int a = 0; a < own; ++a) rows[static_cast<std::ptrdiff_t>(k) * own + a] = row(k)[m + a];
  }
  return true;
}

}  // namespace
}  // namespace geond::charge
