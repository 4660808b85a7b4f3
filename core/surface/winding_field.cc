// SPDX-License-Identifier: Apache-2.0
#include "core/surface/winding_field.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/parallel.h"
#include "core/base/progress.h"

namespace geond {

SignedGrid WindingField(SignedGrid grid, const WindingNumber& winding, const FieldSource& source, int threads,
                        const std::stop_token& stop) {
  const double reach = source.reach;
  // Blocks of 4 x 4 x 4 nodes: the winding number at the eight corners tells whether the inside needs a look.
  constexpr int kBlock = 4;
  const std::array<int, 3> blocks{(grid.size[0] + kBlock - 1) / kBlock, (grid.size[1] + kBlock - 1) / kBlock,
                                  (grid.size[2] + kBlock - 1) / kBlock};
  const std::array<int, 3> corners{blocks[0] + 1, blocks[1] + 1, blocks[2] + 1};
  std::vector<float> coarse(static_cast<std::size_t>(corners[0]) * corners[1] * corners[2]);
  const auto corner_index = [&](int i, int j, int k) { return (static_cast<std::size_t>(k) * corners[1] + j) * corners[0] + i; };
  ParallelFor(static_cast<std::ptrdiff_t>(corners[1]) * corners[2], threads, 1, [&](std::ptrdiff_t line) {
    ThrowIfStopped(stop);
    const int j = static_cast<int>(line % corners[1]), k = static_cast<int>(line / corners[1]);
    for (int i = 0; i < corners[0]; ++i) {
      coarse[corner_index(i, j, k)] = static_cast<float>(winding.At(grid.node(kBlock * i, kBlock * j, kBlock * k)));
    }
  });
  ParallelFor(static_cast<std::ptrdiff_t>(blocks[1]) * blocks[2], threads, 1, [&](std::ptrdiff_t line) {
    ThrowIfStopped(stop);
    const int bj = static_cast<int>(line % blocks[1]), bk = static_cast<int>(line / blocks[1]);
    for (int bi = 0; bi < blocks[0]; ++bi) {
      double low = 1e9, high = -1e9;
      for (int c = 0; c < 8; ++c) {
        const double w = coarse[corner_index(bi + (c & 1), bj + (c >> 1 & 1), bk + (c >> 2))];
        low = std::min(low, w);
        high = std::max(high, w);
      }
      const Eigen::Vector3d middle = grid.node(kBlock * bi, kBlock * bj, kBlock * bk) + Eigen::Vector3d::Constant(0.5 * kBlock * grid.step);
      const double half_diagonal = 0.5 * std::numbers::sqrt3 * kBlock * grid.step;
      const bool is_far = source.distance(middle, half_diagonal + reach) >= half_diagonal + reach;
      const bool uniform = is_far && (low > 0.6 || high < 0.4);
      for (int k = kBlock * bk; k < std::min(kBlock * (bk + 1), grid.size[2]); ++k) {
        for (int j = kBlock * bj; j < std::min(kBlock * (bj + 1), grid.size[1]); ++j) {
          for (int i = kBlock * bi; i < std::min(kBlock * (bi + 1), grid.size[0]); ++i) {
            double value = (low > 0.5 ? -1.0 : 1.0) * reach;
            if (!uniform) {
              const Eigen::Vector3d p = grid.node(i, j, k);
              const auto at = [&] { return winding.At(p); };
              const std::optional<double> near = is_far ? std::nullopt : source.value(p, at);
              value = near ? *near : std::clamp(1.0 - 2.0 * at(), -1.0, 1.0) * reach;
            }
            const bool border = i == 0 || j == 0 || k == 0 || i + 1 == grid.size[0] || j + 1 == grid.size[1] || k + 1 == grid.size[2];
            grid.value[grid.index(i, j, k)] = static_cast<float>(border ? reach : value);
          }
        }
      }
    }
  });
  return grid;
}

}  // namespace geond
