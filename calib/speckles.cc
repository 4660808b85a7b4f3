// SPDX-License-Identifier: Apache-2.0
#include "calib/speckles.h"

#include <vector>

namespace geond::calib {

void RejectSpeckles(RangeView& view, int least_pixels) {
  std::vector<bool> visited(view.classes.size(), false);
  std::vector<std::size_t> group;
  for (std::size_t seed = 0; seed < view.classes.size(); ++seed) {
    if (visited[seed] || !view.IsObject(seed)) continue;
    visited[seed] = true;
    group.assign(1, seed);
    for (std::size_t next = 0; next < group.size(); ++next) {
      const int column = static_cast<int>(group[next] % view.image.columns), row = static_cast<int>(group[next] / view.image.columns);
      for (int r = row - 1; r <= row + 1; ++r) {
        for (int c = column - 1; c <= column + 1; ++c) {
          if (!view.image.contains(c, r)) continue;
          const std::size_t pixel = view.image.index(c, r);
          if (visited[pixel] || !view.IsObject(pixel)) continue;
          visited[pixel] = true;
          group.push_back(pixel);
        }
      }
    }
    if (static_cast<int>(group.size()) >= least_pixels) continue;
    for (std::size_t pixel : group) view.classes[pixel] = PixelClass::kRejected;
  }
}

}  // namespace geond::calib
