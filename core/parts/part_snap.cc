// SPDX-License-Identifier: Apache-2.0
// Boundaries drawn to creases by minimum cuts.
#include "core/parts/part_snap.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <queue>
#include <utility>

#include "core/base/progress.h"
#include "core/parts/concavity.h"
#include "core/parts/min_cut.h"
#include "core/parts/watershed.h"

namespace geond {
namespace {

constexpr double kFar = std::numeric_limits<double>::infinity();

// The cost of cutting over each arc, computed when first asked for.
class CutCosts {
 public:
  CutCosts(const SurfaceGraph& surface, const SnapSettings& settings)
      : surface_(surface), settings_(settings), walk_(surface), costs_(surface.to.size(), -1.0) {}

  // Over the arc from t to a piece of higher number.
  double At(int t, int arc) {
    double& cost = costs_[arc];
    if (cost < 0.0) {
      const double concavity = ConcavityAcross(surface_, walk_, {t, arc, surface_.to[arc]}, settings_.radius);
      cost = surface_.lengths[arc] * std::exp(-std::max(concavity, settings_.convex_clip) / settings_.scale);
    }
    return cost;
  }

 private:
  const SurfaceGraph& surface_;
  const SnapSettings& settings_;
  BallWalk walk_;
  std::vector<double> costs_;
};

// The pieces of regions a and b within `limit` of the boundary, over the surface from centroid to centroid, with
// their distances; those of a region beyond are left out. `distance` must be kFar everywhere and is so again only after
// clearing.
std::vector<int> Band(const SurfaceGraph& surface, const std::vector<int>& labels, const std::vector<int>& start, int a,
                      int b, double limit, std::vector<double>& distance) {
  using Entry = std::pair<double, int>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  std::vector<int> band;
  for (int t : start) {
    distance[t] = 0.0;
    queue.push({0.0, t});
  }
  while (!queue.empty()) {
    const auto [d, t] = queue.top();
    queue.pop();
    if (d > distance[t]) continue;
    band.push_back(t);
    for (int next : surface.Neighbors(t)) {
      if ((labels[next] != a && labels[next] != b)) continue;
      const double through = d + (surface.centroids[next] - surface.centroids[t]).norm();
      if (through > limit || through >= distance[next]) continue;
      distance[next] = through;
      queue.push({through, next});
    }
  }
  return band;
}

}  // namespace

void SnapBoundaries(const SurfaceGraph& surface, const SnapSettings& settings, std::vector<int>& labels,
                    std::stop_token stop) {
  std::map<std::pair<int, int>, std::vector<int>> boundaries;
  for (int t = 0; t < surface.n(); ++t) {
    for (int next : surface.Neighbors(t)) {
      if (labels[next] == labels[t]) continue;
      std::vector<int>& list = boundaries[std::minmax(labels[t], labels[next])];
      if (list.empty() || list.back() != t) list.push_back(t);
    }
  }
  CutCosts costs(surface, settings);
  std::vector<double> distance(surface.n(), kFar);
  std::vector<int> node(surface.n(), -1);
  for (const auto& [pair, start_list] : boundaries) {
    ThrowIfStopped(stop);
    const auto [a, b] = pair;
    std::vector<int> start;  // what earlier cuts left of this boundary
    for (int t : start_list) {
      if (labels[t] == a || labels[t] == b) start.push_back(t);
    }
    if (start.empty()) continue;
    const std::vector<int> band = Band(surface, labels, start, a, b, settings.band, distance);
    // A region that lies in the band altogether keeps its inner half.
    double depth[2] = {0.0, 0.0};
    bool open[2] = {false, false};
    for (int t : band) {
      const int s = labels[t] == a ? 0 : 1;
      depth[s] = std::max(depth[s], distance[t]);
      for (int next : surface.Neighbors(t)) {
        if (labels[next] == labels[t] && distance[next] == kFar) open[s] = true;
      }
    }
    for (std::size_t i = 0; i < band.size(); ++i) node[band[i]] = static_cast<int>(i);
    MinCut cut(static_cast<int>(band.size()));
    for (int t : band) {
      const int s = labels[t] == a ? 0 : 1;
      bool anchored = distance[t] > 0.6 * depth[s] && !open[s];
      for (int arc = surface.first[t]; arc < surface.first[t + 1]; ++arc) {
        const int next = surface.to[arc];
        if (node[next] < 0) {
          if (labels[next] == labels[t]) anchored = true;
        } else if (next > t) {
          const double relative = costs.At(t, arc) / surface.edge;
          cut.Connect(node[t], node[next], 1 + static_cast<std::int64_t>(1e6 * std::min(relative, 1e6)));
        }
      }
      if (anchored) s == 0 ? cut.AttachToSource(node[t]) : cut.AttachToSink(node[t]);
    }
    const std::vector<bool> on_a = cut.Solve(stop);
    for (std::size_t i = 0; i < band.size(); ++i) {
      labels[band[i]] = on_a[i] ? a : b;
    }
    for (int t : band) {
      distance[t] = kFar;
      node[t] = -1;
    }
  }
  JoinSplinters(surface, labels);
}

}  // namespace geond
