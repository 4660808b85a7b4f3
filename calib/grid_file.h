// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <vector>

#include <Eigen/Core>

namespace geond::calib {

// Points in rows and columns as a range scanner wrote them, in the file's frame and unit.
struct PointGrid {
  int columns = 0, rows = 0;
  std::vector<Eigen::Vector3d> points;
  std::vector<int> cells;  // index into points, row by row; -1: none
};

// Reads a PLY file (ascii or binary) with an element range_grid; unpacks it first if its name ends in .xz. Throws FileError
// naming line or byte; takes no more memory than the file's content justifies.
PointGrid ReadGridFile(const std::filesystem::path& path);

}  // namespace geond::calib
