// SPDX-License-Identifier: Apache-2.0
#include "core/geon/outliers.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "core/geon/nearest.h"

namespace geond {
namespace {

constexpr std::size_t kNeighbours = 10;
constexpr int kLeastSupport = 2;
constexpr double kLeastShare = 0.05;

}  // namespace

std::vector<bool> FindOutliers(const std::vector<Eigen::Vector3d>& points, const std::vector<Eigen::Vector3d>& normals) {
  const std::size_t n = points.size();
  std::vector<bool> outlier(n, false);
  if (n < 4 * kNeighbours) return outlier;
  std::vector<int> neighbour(n * kNeighbours);
  std::vector<double> heights;
  for (std::size_t i = 0; i < n; ++i) {
    Nearest<kNeighbours> near;
    for (std::size_t j = 0; j < n; ++j) {
      if (j != i) near.Add((points[j] - points[i]).squaredNorm(), static_cast<int>(j));
    }
    for (std::size_t k = 0; k < kNeighbours; ++k) {
      const int j = neighbour[i * kNeighbours + k] = near.place[k];
      heights.push_back(std::abs(normals[i].dot(points[j] - points[i])));
    }
  }
  std::nth_element(heights.begin(), heights.begin() + static_cast<std::ptrdiff_t>(heights.size() / 2), heights.end());
  const double tolerance = 2.0 * heights[heights.size() / 2];
  std::size_t found = 0;
  for (std::size_t i = 0; i < n; ++i) {
    int support = 0;
    for (std::size_t k = 0; k < kNeighbours; ++k) {
      const int j = neighbour[i * kNeighbours + k];
      const Eigen::Vector3d d = points[j] - points[i];
      const double limit = tolerance + 0.2 * d.norm();
      support += normals[i].dot(normals[j]) > 0.4 && std::abs(normals[i].dot(d)) < limit && std::abs(normals[j].dot(d)) < limit;
    }
    outlier[i] = support < kLeastSupport;
    found += outlier[i];
  }
  if (static_cast<double>(found) < kLeastShare * static_cast<double>(n)) outlier.assign(n, false);
  return outlier;
}

}  // namespace geond
