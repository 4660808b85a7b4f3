// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include <Eigen/Core>

namespace geond {

// Which points agree with no surface through their neighbours: fewer than two of the ten nearest lie in the point's tangent
// plane, it in theirs, with normals on one side. True for an outlier. Clean data have a few such points at corners and where
// they are sparse: unless at least 5 % are, none is called one. No shape is presumed, so every type is judged on the same
// points. Quadratic in the number of points.
std::vector<bool> FindOutliers(const std::vector<Eigen::Vector3d>& points, const std::vector<Eigen::Vector3d>& normals);

}  // namespace geond
