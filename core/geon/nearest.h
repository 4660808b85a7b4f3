// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <limits>

namespace geond {

// The `kCount` least of the squared distances that come, least first, each with its place; of equal ones the first to come.
template <std::size_t kCount>
struct Nearest {
  std::array<double, kCount> square;
  std::array<int, kCount> place;

  Nearest() {
    square.fill(std::numeric_limits<double>::infinity());
    place.fill(-1);
  }
  void Add(double s, int at) {
    if (!(s < square.back())) return;
    std::size_t k = kCount - 1;
    for (; k > 0 && s < square[k - 1]; --k) {
      square[k] = square[k - 1];
      place[k] = place[k - 1];
    }
    square[k] = s;
    place[k] = at;
  }
};

}  // namespace geond
