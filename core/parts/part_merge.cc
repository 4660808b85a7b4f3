// SPDX-License-Identifier: Apache-2.0
// Regions between which nobody would cut become one.
#include "core/parts/part_merge.h"

#include <algorithm>
#include <limits>
#include <map>
#include <set>
#include <tuple>
#include <utility>

#include "core/base/progress.h"
#include "core/parts/concavity.h"

namespace geond {
namespace {

// Regions and borders of a labelling, numbered by label.
struct LabelledSurface {
  std::vector<SurfaceRegion> regions;
  std::map<std::pair<int, int>, RegionBorder> borders;  // a < b
  SurfaceScale scale;
};

LabelledSurface Measure(const SurfaceGraph& surface, const std::vector<int>& labels, const std::vector<double>& charge,
                        const MergeSettings& settings) {
  LabelledSurface result;
  result.regions.resize(labels.empty() ? 0 : 1 + *std::max_element(labels.begin(), labels.end()));
  double all_charge = 0.0;
  for (int t = 0; t < surface.n(); ++t) {
    all_charge += surface.areas[t] * charge[t];
    if (labels[t] < 0) continue;
    SurfaceRegion& region = result.regions[labels[t]];
    region.area += surface.areas[t];
    region.area_vector += surface.area_vectors[t];
    region.charge += surface.areas[t] * charge[t];
    region.peak = std::max(region.peak, charge[t]);
  }
  result.scale.area = surface.area;
  result.scale.density = surface.area > 0.0 ? all_charge / surface.area : 0.0;
  result.scale.noise = settings.radius > 0.0 ? settings.noise / settings.radius : 0.0;
  BallWalk walk(surface);
  for (const SurfaceEdge& edge : CollectEdges(
           surface, [&](int t, int u) { return labels[t] != labels[u] && labels[t] >= 0 && labels[u] >= 0; })) {
    const int a = labels[edge.from], b = labels[edge.to];
    const double length = surface.lengths[edge.arc];
    result.borders[std::minmax(a, b)].Add(length, ConcavityBetweenLabels(surface, walk, edge, labels, settings.radius),
                                          charge[edge.from], charge[edge.to]);
    result.regions[a].rim += length;
    result.regions[b].rim += length;
  }
  return result;
}

// Regions as a graph that shrinks: weak borders in the order in which they are to go.
class RegionGraph {
 public:
  RegionGraph(LabelledSurface surface, CutStage stage)
      : stage_(stage),
        scale_(surface.scale),
        regions_(std::move(surface.regions)),
        parent_(regions_.size()),
        at_(regions_.size()) {
    for (std::size_t i = 0; i < parent_.size(); ++i) parent_[i] = static_cast<int>(i);
    for (const auto& [pair, border] : surface.borders) {
      at_[pair.first][pair.second].border = at_[pair.second][pair.first].border = border;
    }
    for (const auto& [pair, border] : surface.borders) Enqueue(pair.first, pair.second);
  }

  int Root(int region) const {
    while (parent_[region] != region) region = parent_[region];
    return region;
  }

  // Merges over the borders below these odds.
  void DissolveWeak(double log_odds) {
    while (!queue_.empty()) {
      const auto [odds, a, b] = *queue_.begin();
      if (!(odds < log_odds)) return;
      Merge(a, b);
    }
  }

  // Regions below these shares of the area or of the charge join the neighbour over their weakest border, the smallest
  // first.
  void AbsorbSmall(double area_share, double charge_share) {
    const auto is_small = [&](const SurfaceRegion& region) {
      return region.area < area_share * scale_.area || region.charge < charge_share * scale_.area * scale_.density;
    };
    std::set<std::pair<double, int>> small;
    for (int r = 0; r < static_cast<int>(regions_.size()); ++r) {
      if (parent_[r] == r && is_small(regions_[r])) small.insert({regions_[r].area, r});
    }
    while (!small.empty()) {
      const int smallest = small.begin()->second;
      small.erase(small.begin());
      if (at_[smallest].empty()) continue;  // apart from all others
      int best = -1;
      double best_odds = 0.0;
      for (const auto& [other, entry] : at_[smallest]) {
        if (best < 0 || entry.odds < best_odds) best = other, best_odds = entry.odds;
      }
      small.erase({regions_[best].area, best});
      const int kept = Merge(smallest, best);
      if (is_small(regions_[kept])) small.insert({regions_[kept].area, kept});
    }
  }

 private:
  using Key = std::tuple<double, int, int>;  // odds, a, b
  struct Entry {
    RegionBorder border;
    double odds = 0.0;  // as it stands in the queue
  };

  void Enqueue(int a, int b) {
    Entry& entry = at_[a].at(b);
    entry.odds = LogOddsOfCut(EvidenceForCut(regions_[a], regions_[b], entry.border, scale_), stage_);
    at_[b].at(a).odds = entry.odds;
    queue_.insert({entry.odds, std::min(a, b), std::max(a, b)});
  }

  void Dequeue(int a, int b) { queue_.erase(Key{at_[a].at(b).odds, std::min(a, b), std::max(a, b)}); }

  int Merge(int a, int b) {
    const int into = std::min(a, b), from = std::max(a, b);
    for (int r : {into, from}) {
      for (const auto& [other, entry] : at_[r]) Dequeue(r, other);
    }
    const double dissolved = at_[into].at(from).border.length;
    at_[into].erase(from);
    at_[from].erase(into);
    for (const auto& [other, moved] : at_[from]) {
      RegionBorder& border = at_[into][other].border;
      border.Add(moved.border);
      at_[other].erase(from);
      at_[other][into].border = border;
    }
    at_[from].clear();
    parent_[from] = into;
    SurfaceRegion& kept = regions_[into];
    kept.area += regions_[from].area;
    kept.area_vector += regions_[from].area_vector;
    kept.charge += regions_[from].charge;
    kept.peak = std::max(kept.peak, regions_[from].peak);
    kept.rim += regions_[from].rim - 2.0 * dissolved;
    for (const auto& [other, entry] : at_[into]) Enqueue(into, other);
    return into;
  }

  CutStage stage_;
  SurfaceScale scale_;
  std::vector<SurfaceRegion> regions_;
  std::vector<int> parent_;
  std::vector<std::map<int, Entry>> at_;
  std::set<Key> queue_;
};

void NumberAnew(std::vector<int>& labels) {
  std::vector<int> number(labels.empty() ? 0 : 1 + *std::max_element(labels.begin(), labels.end()), -1);
  int n = 0;
  for (int& label : labels) {
    if (number[label] < 0) number[label] = n++;
    label = number[label];
  }
}

std::vector<CutCandidate> Candidates(const LabelledSurface& surface) {
  std::vector<CutCandidate> candidates;
  for (const auto& [pair, border] : surface.borders) {
    const auto [a, b] = pair;
    candidates.push_back({a, b, border, EvidenceForCut(surface.regions[a], surface.regions[b], border, surface.scale)});
  }
  return candidates;
}

}  // namespace

std::vector<CutCandidate> MeasureCuts(const SurfaceGraph& surface, const std::vector<int>& labels,
                                      const std::vector<double>& charge, const MergeSettings& settings) {
  return Candidates(Measure(surface, labels, charge, settings));
}

void MergeRegions(const SurfaceGraph& surface, const std::vector<double>& charge, const MergeSettings& settings,
                  std::vector<int>& labels, std::stop_token stop) {
  const auto run = [&](double log_odds, double small_area, double small_charge) {
    ThrowIfStopped(stop);
    NumberAnew(labels);
    LabelledSurface measured = Measure(surface, labels, charge, settings);
    if (settings.on_measured) settings.on_measured(labels, Candidates(measured), settings.stage);
    RegionGraph graph(std::move(measured), settings.stage);
    graph.DissolveWeak(log_odds);
    graph.AbsorbSmall(small_area, small_charge);
    for (int& label : labels) label = graph.Root(label);
  };
  for (double log_odds : settings.log_odds) run(log_odds, 0.0, 0.0);
  if (settings.small_area > 0.0 || settings.small_charge > 0.0) {
    run(settings.log_odds.empty() ? -std::numeric_limits<double>::infinity() : settings.log_odds.back(),
        settings.small_area, settings.small_charge);
  }
  NumberAnew(labels);
}

}  // namespace geond
