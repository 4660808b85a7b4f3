// SPDX-License-Identifier: Apache-2.0
// Regions that no concavity divides become one.
#include "core/parts/part_merge.h"

#include <algorithm>
#include <map>
#include <set>
#include <tuple>
#include <utility>

#include "core/base/progress.h"
#include "core/parts/concavity.h"

namespace geond {
namespace {

// What is known of a region.
struct Region {
  double area = 0.0;
  double charge = 0.0;  // density times area
  double rim = 0.0;     // length of its boundaries
};

// Regions as a graph that shrinks: weak boundaries in the order in which they are to go.
class RegionGraph {
 public:
  RegionGraph(std::vector<Region> regions, const std::vector<RegionBoundary>& boundaries, const MergeSettings& settings)
      : settings_(settings), regions_(std::move(regions)), parent_(regions_.size()), at_(regions_.size()) {
    for (std::size_t i = 0; i < parent_.size(); ++i) parent_[i] = static_cast<int>(i);
    for (const RegionBoundary& b : boundaries) {
      regions_[b.a].rim += b.length;
      regions_[b.b].rim += b.length;
      at_[b.a][b.b] = at_[b.b][b.a] = {b, 0.0};
    }
    for (const RegionBoundary& b : boundaries) Enqueue(b.a, b.b);
  }

  int Root(int region) const {
    while (parent_[region] != region) region = parent_[region];
    return region;
  }

  // Merges over the boundaries below the threshold. Returns the number of merges.
  int DissolveWeak() {
    int merges = 0;
    for (; !queue_.empty(); ++merges) {
      const auto [key, length, a, b] = *queue_.begin();
      Merge(a, b);
    }
    return merges;
  }

  // Regions smaller than `least` join the neighbour over their weakest boundary, the smallest first.
  int AbsorbSmall(double least) {
    std::set<std::pair<double, int>> small;
    for (int r = 0; r < static_cast<int>(regions_.size()); ++r) {
      if (parent_[r] == r && regions_[r].area < least) small.insert({regions_[r].area, r});
    }
    int merges = 0;
    while (!small.empty()) {
      const int smallest = small.begin()->second;
      small.erase(small.begin());
      if (at_[smallest].empty()) continue;  // apart from all others
      int best = -1;
      double best_strength = 0.0;
      for (const auto& [other, entry] : at_[smallest]) {
        const double strength = entry.boundary.strength();
        if (best < 0 || strength < best_strength) best = other, best_strength = strength;
      }
      small.erase({regions_[best].area, best});
      const int into = Merge(smallest, best);
      if (regions_[into].area < least) small.insert({regions_[into].area, into});
      ++merges;
    }
    return merges;
  }

 private:
  using Key = std::tuple<double, double, int, int>;  // order, minus length, a, b
  struct Entry {
    RegionBoundary boundary;
    double order = 0.0;  // as it stands in the queue
  };

  double Density(int r) const { return regions_[r].area > 0.0 ? regions_[r].charge / regions_[r].area : 0.0; }

  void Enqueue(int a, int b) {
    Entry& entry = at_[a].at(b);
    const RegionBoundary& boundary = entry.boundary;
    const double lesser = std::min(Density(a), Density(b)), rim = std::min(regions_[a].rim, regions_[b].rim);
    entry.order = boundary.strength();
    if (lesser > 0.0 && boundary.length > 0.0) {
      entry.order +=
          settings_.contrast_weight * std::clamp(1.0 - boundary.charge / boundary.length / lesser, -1.0, 1.0);
    }
    if (rim > 0.0) entry.order -= settings_.share_weight * boundary.length / rim;
    at_[b].at(a).order = entry.order;
    if (boundary.strength() < settings_.threshold)
      queue_.insert({entry.order, -boundary.length, boundary.a, boundary.b});
  }

  void Dequeue(int a, int b) {
    const Entry& entry = at_[a].at(b);
    queue_.erase(Key{entry.order, -entry.boundary.length, entry.boundary.a, entry.boundary.b});
  }

  int Merge(int a, int b) {
    const int into = std::min(a, b), from = std::max(a, b);
    for (int r : {into, from}) {
      for (const auto& [other, entry] : at_[r]) Dequeue(r, other);
    }
    const double dissolved = at_[into].at(from).boundary.length;
    at_[into].erase(from);
    at_[from].erase(into);
    for (const auto& [other, moved] : at_[from]) {
      RegionBoundary& boundary = at_[into][other].boundary;
      boundary.length += moved.boundary.length;
      boundary.concavity += moved.boundary.concavity;
      boundary.charge += moved.boundary.charge;
      boundary.a = std::min(into, other);
      boundary.b = std::max(into, other);
      at_[other].erase(from);
      at_[other][into].boundary = boundary;
    }
    at_[from].clear();
    parent_[from] = into;
    regions_[into].area += regions_[from].area;
    regions_[into].charge += regions_[from].charge;
    regions_[into].rim += regions_[from].rim - 2.0 * dissolved;
    for (const auto& [other, entry] : at_[into]) Enqueue(into, other);
    return into;
  }

  const MergeSettings& settings_;
  std::vector<Region> regions_;
  std::vector<int> parent_;
  std::vector<std::map<int, Entry>> at_;
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

std::vector<RegionBoundary> MeasureBoundaries(const SurfaceGraph& surface, const std::vector<int>& labels,
                                              const std::vector<double>& charge, const MergeSettings& settings) {
  std::map<std::pair<int, int>, RegionBoundary> boundaries;
  BallWalk walk(surface);
  for (const SurfaceEdge& edge : CollectEdges(surface, [&](int t, int u) { return labels[t] != labels[u]; })) {
    const int a = std::min(labels[edge.from], labels[edge.to]);
    const int b = std::max(labels[edge.from], labels[edge.to]);
    RegionBoundary& boundary = boundaries[{a, b}];
    boundary.a = a;
    boundary.b = b;
    const double concavity = ConcavityBetweenLabels(surface, walk, edge, labels, settings.radius);
    boundary.length += surface.lengths[edge.arc];
    boundary.concavity += surface.lengths[edge.arc] * std::max(concavity, settings.convex_clip);
    boundary.charge += 0.5 * surface.lengths[edge.arc] * (charge[edge.from] + charge[edge.to]);
  }
  std::vector<RegionBoundary> list;
  for (const auto& [pair, boundary] : boundaries) list.push_back(boundary);
  return list;
}

void MergeRegions(const SurfaceGraph& surface, const std::vector<double>& charge, const MergeSettings& settings,
                  std::vector<int>& labels, std::stop_token stop) {
  for (bool absorb = false;;) {
    ThrowIfStopped(stop);
    std::vector<Region> regions(NumberAnew(labels));
    for (int t = 0; t < surface.n(); ++t) {
      regions[labels[t]].area += surface.areas[t];
      regions[labels[t]].charge += surface.areas[t] * charge[t];
    }
    RegionGraph graph(std::move(regions), MeasureBoundaries(surface, labels, charge, settings), settings);
    int merges = graph.DissolveWeak();
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
