// SPDX-License-Identifier: Apache-2.0
#include "core/geometry/stray_points.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numeric>

#include "core/geometry/point_index.h"

namespace geond {
namespace {

constexpr std::size_t kFewestPoints = 50;  // of fewer points none can be called stray
constexpr int kNeighbors = 8;  // the spacing is the distance to the last of these, the point itself among them
constexpr std::size_t kProbes = 1'000;
constexpr double kCell = 3.0;  // edge of a cell, in spacings

// The median distance of points to their kNeighbors-th nearest (m).
double Spacing(const std::vector<Eigen::Vector3d>& points) {
  const PointIndex index(points);
  std::vector<double> distances;
  const std::size_t stride = std::max<std::size_t>(1, points.size() / kProbes);
  for (std::size_t i = 0; i < points.size(); i += stride) {
    distances.push_back(index.Nearest(points[i], kNeighbors).back().second);
  }
  const auto median = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
  std::nth_element(distances.begin(), median, distances.end());
  return std::sqrt(*median);
}

using Cell = std::array<std::int64_t, 3>;

// For each point the index of its group: points in cells that touch hang together.
std::vector<int> Groups(const std::vector<Eigen::Vector3d>& points, double edge) {
  const Eigen::Vector3d low = BoundingBox(points).min();
  std::vector<Cell> cell_of(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (int k = 0; k < 3; ++k) cell_of[i][k] = static_cast<std::int64_t>(std::floor((points[i][k] - low[k]) / edge));
  }
  std::vector<Cell> cells = cell_of;
  std::sort(cells.begin(), cells.end());
  cells.erase(std::unique(cells.begin(), cells.end()), cells.end());
  const auto find = [&](const Cell& cell) {
    const auto at = std::lower_bound(cells.begin(), cells.end(), cell);
    return at != cells.end() && *at == cell ? static_cast<int>(at - cells.begin()) : -1;
  };

  std::vector<int> group(cells.size(), -1), front;
  int n_groups = 0;
  for (std::size_t seed = 0; seed < cells.size(); ++seed) {
    if (group[seed] >= 0) continue;
    group[seed] = n_groups;
    front.assign(1, static_cast<int>(seed));
    while (!front.empty()) {
      const Cell at = cells[front.back()];
      front.pop_back();
      for (int step = 0; step < 27; ++step) {
        const int next = find({at[0] + step % 3 - 1, at[1] + step / 3 % 3 - 1, at[2] + step / 9 - 1});
        if (next < 0 || group[next] >= 0) continue;
        group[next] = n_groups;
        front.push_back(next);
      }
    }
    ++n_groups;
  }

  std::vector<int> of_point(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) of_point[i] = group[find(cell_of[i])];
  return of_point;
}

}  // namespace

PointCloud WithoutStrayPoints(const PointCloud& cloud, double least_share, std::vector<std::string>* notes) {
  if (cloud.size() < kFewestPoints) return cloud;
  const double spacing = Spacing(cloud.points);
  // So many cells that their numbers would not fit: one point lies absurdly far away, or most coincide.
  if (!(spacing * 1e9 > BoundingBox(cloud.points).diagonal().norm())) return cloud;
  const std::vector<int> groups = Groups(cloud.points, kCell * spacing);
  std::vector<int> size(*std::max_element(groups.begin(), groups.end()) + 1, 0);
  for (int group : groups) ++size[group];
  const double least = least_share * *std::max_element(size.begin(), size.end());

  std::vector<int> kept;
  for (std::size_t i = 0; i < groups.size(); ++i) {
    if (size[groups[i]] >= least) kept.push_back(static_cast<int>(i));
  }
  const std::size_t strays = cloud.size() - kept.size();
  if (strays == 0 || 10 * strays > cloud.size()) return cloud;
  if (notes) notes->push_back(std::to_string(strays) + " stray points, apart from the rest, were left out");
  return Select(cloud, kept);
}

}  // namespace geond
