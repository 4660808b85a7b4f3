// SPDX-License-Identifier: Apache-2.0
#include "core/charge/one_sign.h"

#include <algorithm>
#include <array>
#include <utility>

namespace geond::charge {
namespace {

// Triangles that share an edge, both ways round, sorted.
std::vector<std::array<int, 2>> NeighboursOf(const TriangleMesh& mesh) {
  struct Side {
    int low, high, triangle;
    bool operator<(const Side& other) const {
      return std::pair(std::pair(low, high), triangle) < std::pair(std::pair(other.low, other.high), other.triangle);
    }
  };
  std::vector<Side> sides;
  for (int t = 0; t < static_cast<int>(mesh.triangles.size()); ++t) {
    for (int e = 0; e < 3; ++e) {
      const auto [low, high] = std::minmax(mesh.triangles[t][e], mesh.triangles[t][(e + 1) % 3]);
      sides.push_back({low, high, t});
    }
  }
  std::sort(sides.begin(), sides.end());
  std::vector<std::array<int, 2>> pairs;
  for (std::size_t i = 0; i < sides.size(); ++i) {
    for (std::size_t j = i + 1; j < sides.size() && sides[j].low == sides[i].low && sides[j].high == sides[i].high;
         ++j) {
      pairs.push_back({sides[i].triangle, sides[j].triangle});
      pairs.push_back({sides[j].triangle, sides[i].triangle});
    }
  }
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

}  // namespace

std::size_t MakeOneSign(const TriangleMesh& mesh, std::span<const double> areas, std::vector<double>& density) {
  const auto count =
      static_cast<std::size_t>(std::count_if(density.begin(), density.end(), [](double d) { return d < 0.0; }));
  if (count == 0) return 0;
  const std::vector<std::array<int, 2>> neighbours = NeighboursOf(mesh);
  const auto total = [&] {
    double sum = 0.0;
    for (std::size_t i = 0; i < areas.size(); ++i) sum += areas[i] * density[i];
    return sum;
  };
  const double charge = total();
  constexpr int kMostSweeps = 20;  // neighbours that bear more than they have pass it on
  for (int sweep = 0, left = 1; left > 0 && sweep < kMostSweeps; ++sweep) {
    left = 0;
    for (int t = 0; t < static_cast<int>(density.size()); ++t) {
      if (density[t] >= 0.0) continue;
      const auto begin = std::lower_bound(neighbours.begin(), neighbours.end(), std::array<int, 2>{t, 0});
      double have = 0.0;
      for (auto n = begin; n != neighbours.end() && (*n)[0] == t; ++n) {
        have += std::max(0.0, density[(*n)[1]]) * areas[(*n)[1]];
      }
      if (have == 0.0) continue;
      ++left;
      const double kept = 1.0 + density[t] * areas[t] / have;
      density[t] = 0.0;
      for (auto n = begin; n != neighbours.end() && (*n)[0] == t; ++n) {
        if (density[(*n)[1]] > 0.0) density[(*n)[1]] *= kept;
      }
    }
  }
  // What no neighbour could bear, as inside a closed shell, all bear.
  for (double& d : density) d = std::max(d, 0.0);
  const double scale = charge / total();
  for (double& d : density) d *= scale;
  return count;
}

}  // namespace geond::charge
