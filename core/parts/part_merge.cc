// SPDX-License-Identifier: Apache-2.0
// Regions that no concavity divides become one.
#include "core/parts/part_merge.h"

#include <algorithm>
#include <map>
#include <set>
#include <tuple>

#include "core/base/progress.h"
#include "core/parts/concavity.h"

namespace geond {
namespace {

// Regions as a graph that shrinks: boundaries sorted by strength, merged pair by pair.
class RegionGraph {
 public:
  RegionGraph(std::vector<double> areas, const std::vector<RegionBoundary>& boundaries)
      : areas_(std::move(areas)), parent_(areas_.size()), at_(areas_.size()) {
    for (std::size_t i = 0; i < parent_.size(); ++i) parent_[i] = static_cast<int>(i);
    for (const RegionBoundary& boundary : boundaries) Insert(boundary);
  }

  int Root(int region) const {
    while (parent_[region] != region) region = parent_[region];
    return region;
  }

  // Merges while the weakest boundary is below the threshold. Returns the number of merges.
  int DissolveBelow(double threshold) {
    int merges = 0;
    while (!queue_.empty() && std::get<0>(*queue_.begin()) < threshold) {
      const auto [strength, length, a, b] = *queue_.begin();
      Merge(a, b);
      ++merges;
    }
    return merges;
  }

  // Regions smaller than `least` join the neighbour over their weakest boundary, the smallest first.
  int AbsorbSmall(double least) {
    int merges = 0;
    for (;;) {
      int smallest = -1;
      for (int r = 0; r < static_cast<int>(areas_.size()); ++r) {
        if (parent_[r] != r || at_[r].empty() || areas_[r] >= least) continue;
        if (smallest < 0 || areas_[r] < areas_[smallest]) smallest = r;
      }
      if (smallest < 0) return merges;
      int best = -1;
      double best_strength = 0.0;
      for (const auto& [other, boundary] : at_[smallest]) {
        if (best < 0 || boundary.strength() < best_strength) best = other, best_strength = boundary.strength();
      }
      Merge(smallest, best);
      ++merges;
    }
  }

 private:
  using Key = std::tuple<double, double, int, int>;  // strength, minus length, a, b
  static Key KeyOf(const RegionBoundary& b) { return {b.strength(), -b.length, b.a, b.b}; }

  void Insert(const RegionBoundary& boundary) {
    queue_.insert(KeyOf(boundary));
    at_[boundary.a][boundary.b] = boundary;
    at_[boundary.b][boundary.a] = boundary;
  }

  RegionBoundary Remove(int a, int b) {
    const RegionBoundary boundary = at_[a].at(b);
    queue_.erase(KeyOf(boundary));
    at_[a].erase(b);
    at_[b].erase(a);
    return boundary;
  }

  void Merge(int a, int b) {
    const int into = std::min(a, b), from = std::max(a, b);
    Remove(a, b);
    const std::map<int, RegionBoundary> moved = at_[from];
    for (const auto& [other, unused] : moved) {
      RegionBoundary boundary = Remove(from, other);
      if (at_[into].contains(other)) {
        const RegionBoundary mine = Remove(into, other);
        boundary.length += mine.length;
        boundary.weighted += mine.weighted;
      }
      boundary.a = std::min(into, other);
      boundary.b = std::max(into, other);
      Insert(boundary);
    }
    parent_[from] = into;
    areas_[into] += areas_[from];
  }

  std::vector<double> areas_;
  std::vector<int> parent_;
  std::vector<std::map<int, RegionBoundary>> at_;
  std::set<Key> queue_;
};

int NumberAnew(std::vector<int>& labels) {
  std::vector<int> number(labels.empty() ? 0 : 1 + *std::max_element(labels.begin(), labels.end()), -1);
  int n = 0;
  for (int& label : labels) {
    if (number[label] < 0) number[label] = n++;
    label = number[label];
  }
  return n;
}

}  // namespace

std::vector<RegionBoundary> MeasureBoundaries(const PartSurface& surface, const std::vector<int>& labels,
                                              const MergeSettings& settings) {
  std::map<std::pair<int, int>, RegionBoundary> boundaries;
  BallWalk walk(surface);
  for (const SurfaceEdge& edge : CollectEdges(surface, [&](int t, int u) { return labels[t] != labels[u]; })) {
    const int a = std::min(labels[edge.triangle], labels[edge.other]);
    const int b = std::max(labels[edge.triangle], labels[edge.other]);
    RegionBoundary& boundary = boundaries[{a, b}];
    boundary.a = a;
    boundary.b = b;
    const double concavity = ConcavityBetweenLabels(surface, walk, edge, labels, settings.radius);
    boundary.length += edge.length;
    boundary.weighted += edge.length * std::max(concavity, settings.convex_clip);
  }
  std::vector<RegionBoundary> list;
  for (const auto& [pair, boundary] : boundaries) list.push_back(boundary);
  return list;
}

void MergeRegions(const PartSurface& surface, const MergeSettings& settings, std::vector<int>& labels,
                  std::stop_token stop) {
  for (bool absorb = false;;) {
    ThrowIfStopped(stop);
    const int n = NumberAnew(labels);
    std::vector<double> areas(n, 0.0);
    for (int t = 0; t < surface.n(); ++t) areas[labels[t]] += surface.areas[t];
    RegionGraph graph(areas, MeasureBoundaries(surface, labels, settings));
    int merges = graph.DissolveBelow(settings.threshold);
    if (merges == 0 && absorb) return;
    if (merges == 0) {
      absorb = true;
      merges = graph.AbsorbSmall(settings.small_area * surface.area);
      if (merges == 0) return;
    }
    for (int& label : labels) label = graph.Root(label);
  }
}

}  // namespace geond
