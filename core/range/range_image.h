// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <vector>

namespace geond {

// Depth z in S of every pixel, row by row, m; NaN where there is no return.
struct RangeImage {
  int columns = 0;
  int rows = 0;
  std::vector<float> depth;

  std::size_t index(int column, int row) const { return static_cast<std::size_t>(row) * columns + column; }
  float at(int column, int row) const { return depth[index(column, row)]; }
  bool contains(int column, int row) const { return column >= 0 && row >= 0 && column < columns && row < rows; }
};

// One range image and how it was taken.
struct Exposure {
  RangeImage image;
  double table_angle = 0.0;               // rad, as the turntable reads it, counter-clockwise seen from above
  std::chrono::nanoseconds timestamp{0};  // the device's clock
};

}  // namespace geond
