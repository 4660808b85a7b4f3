// SPDX-License-Identifier: Apache-2.0
#include "core/parts/unseen_cuts.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace geond {
namespace {

constexpr int kReach = 2;                 // triangles: the surface this near to seen ones is known well enough
constexpr double kLeastSeenOfCut = 0.6;   // of a boundary's length, or its parts are joined
constexpr double kLeastSeenOfPart = 0.3;  // of a part's area, or it joins a neighbour
constexpr double kWellSeen = 0.8;         // of the surface: where less was seen at all, less of a cut has to be

std::vector<std::uint8_t> Widened(const SurfaceGraph& surface, std::vector<std::uint8_t> seen) {
  for (int step = 0; step < kReach; ++step) {
    std::vector<std::uint8_t> wider = seen;
    for (int t = 0; t < surface.n(); ++t) {
      for (int next : surface.Neighbors(t)) {
        if (seen[next]) wider[t] = 1;
      }
    }
    seen = std::move(wider);
  }
  return seen;
}

struct Cut {
  double length = 0.0, seen = 0.0;  // edges, counted by the square root of the areas beside them
};

// The boundaries between labels (lower first).
std::map<std::pair<int, int>, Cut> Cuts(const SurfaceGraph& surface, const std::vector<std::uint8_t>& seen,
                                        const std::vector<int>& labels) {
  std::map<std::pair<int, int>, Cut> cuts;
  for (int t = 0; t < surface.n(); ++t) {
    for (int next : surface.Neighbors(t)) {
      if (labels[t] < 0 || labels[t] >= labels[next]) continue;
      const double length = std::sqrt(surface.areas[t] + surface.areas[next]);
      Cut& cut = cuts[{labels[t], labels[next]}];
      cut.length += length;
      if (seen[t] && seen[next]) cut.seen += length;
    }
  }
  return cuts;
}

// 1 for a surface seen all round; half of it was seen of what one view shows.
double ShareExpected(const SurfaceGraph& surface, const std::vector<std::uint8_t>& seen) {
  double area = 0.0;
  for (int t = 0; t < surface.n(); ++t) area += seen[t] ? surface.areas[t] : 0.0;
  return std::min(1.0, area / (kWellSeen * surface.area));
}

// The pair of parts to join next, or none; `expected`: of ShareExpected.
std::pair<int, int> NextJoin(const SurfaceGraph& surface, const std::vector<std::uint8_t>& seen,
                             const std::vector<std::uint8_t>& near_seen, const std::vector<int>& labels,
                             double expected) {
  const std::map<std::pair<int, int>, Cut> cuts = Cuts(surface, near_seen, labels);
  std::pair<int, int> worst{-1, -1};
  double least = kLeastSeenOfCut * expected;
  for (const auto& [pair, cut] : cuts) {
    if (cut.seen < least * cut.length) {
      least = cut.seen / cut.length;
      worst = pair;
    }
  }
  if (worst.first >= 0) return worst;

  std::map<int, std::pair<double, double>> areas;  // all, seen
  for (int t = 0; t < surface.n(); ++t) {
    areas[labels[t]].first += surface.areas[t];
    if (seen[t]) areas[labels[t]].second += surface.areas[t];
  }
  double longest = 0.0;
  for (const auto& [pair, cut] : cuts) {
    for (int part : {pair.first, pair.second}) {
      const auto& [all, seen_area] = areas[part];
      if (seen_area < kLeastSeenOfPart * expected * all && cut.length > longest) {
        longest = cut.length;
        worst = pair;
      }
    }
  }
  return worst;
}

}  // namespace

void JoinOverUnseen(const SurfaceGraph& surface, const std::vector<std::uint8_t>& seen, std::vector<int>& labels) {
  const std::vector<std::uint8_t> near_seen = Widened(surface, seen);
  const double expected = ShareExpected(surface, seen);
  for (;;) {
    const auto [keep, join] = NextJoin(surface, seen, near_seen, labels, expected);
    if (keep < 0) return;
    std::replace(labels.begin(), labels.end(), join, keep);
  }
}

}  // namespace geond
