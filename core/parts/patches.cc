// SPDX-License-Identifier: Apache-2.0
// Patches of a finely meshed surface.
#include "core/parts/patches.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <queue>
#include <tuple>
#include <utility>

namespace geond {
namespace {

constexpr int kLloydSteps = 3;
constexpr double kLeastShare = 0.2;  // of the wanted area: smaller patches are given up between two steps

// Where a patch grows from, and which way it faces (zero: no matter).
struct Seed {
  int piece = 0;
  Eigen::Vector3d facing = Eigen::Vector3d::Zero();
};

// Grows patches from the seeds, the nearest piece to its patch's seed first; a piece that faces another way counts as
// further off, by up to 2 `width`, so that patches do not reach round creases and necks. Pieces no seed reaches found
// patches of their own. Returns the number of patches.
int Grow(const SurfaceGraph& surface, std::vector<Seed> seeds, double width, std::vector<int>& patch) {
  using Entry = std::tuple<double, int, int>;  // distance squared, piece, patch
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  patch.assign(surface.n(), -1);
  const auto distance = [&](int piece, const Seed& seed) {
    const double turned =
        seed.facing.isZero() ? 0.0 : 1.0 - surface.area_vectors[piece].stableNormalized().dot(seed.facing);
    return (surface.centroids[piece] - surface.centroids[seed.piece]).squaredNorm() + 2.0 * width * width * turned;
  };
  const auto run = [&] {
    while (!queue.empty()) {
      const auto [unused, piece, p] = queue.top();
      queue.pop();
      if (patch[piece] >= 0) continue;
      patch[piece] = p;
      for (int next : surface.Neighbors(piece)) {
        if (patch[next] < 0) queue.push({distance(next, seeds[p]), next, p});
      }
    }
  };
  for (std::size_t p = 0; p < seeds.size(); ++p) queue.push({0.0, seeds[p].piece, static_cast<int>(p)});
  run();
  for (int t = 0; t < surface.n(); ++t) {
    if (patch[t] >= 0) continue;
    queue.push({0.0, t, static_cast<int>(seeds.size())});
    seeds.push_back({t, Eigen::Vector3d::Zero()});
    run();
  }
  return static_cast<int>(seeds.size());
}

// Seeds that lie a patch apart: pieces in order, each taking what hangs together around it until the area is reached.
std::vector<Seed> FirstSeeds(const SurfaceGraph& surface, double patch_area) {
  std::vector<Seed> seeds;
  std::vector<int> patch(surface.n(), -1);
  using Entry = std::pair<double, int>;
  for (int t = 0; t < surface.n(); ++t) {
    if (patch[t] >= 0) continue;
    const Eigen::Vector3d facing = surface.area_vectors[t].stableNormalized();
    double area = 0.0;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
    queue.push({0.0, t});
    while (!queue.empty() && area < patch_area) {
      const auto [distance, piece] = queue.top();
      queue.pop();
      if (patch[piece] >= 0) continue;
      patch[piece] = t;
      area += surface.areas[piece];
      for (int next : surface.Neighbors(piece)) {
        if (patch[next] >= 0 || surface.area_vectors[next].dot(facing) < 0.0) continue;
        queue.push({(surface.centroids[next] - surface.centroids[t]).squaredNorm(), next});
      }
    }
    if (area >= kLeastShare * patch_area) seeds.push_back({t, facing});
  }
  return seeds;
}

// The piece of each patch that lies nearest to its centroid, and the patch's mean facing, for patches that are large
// enough.
std::vector<Seed> Middles(const SurfaceGraph& surface, const std::vector<int>& patch, int n, double least_area) {
  std::vector<Eigen::Vector3d> centroids(n, Eigen::Vector3d::Zero()), facing(n, Eigen::Vector3d::Zero());
  std::vector<double> areas(n, 0.0);
  for (int t = 0; t < surface.n(); ++t) {
    centroids[patch[t]] += surface.areas[t] * surface.centroids[t];
    facing[patch[t]] += surface.area_vectors[t];
    areas[patch[t]] += surface.areas[t];
  }
  std::vector<int> middle(n, -1);
  std::vector<double> best(n, std::numeric_limits<double>::infinity());
  for (int t = 0; t < surface.n(); ++t) {
    const int p = patch[t];
    if (!(areas[p] > least_area)) continue;
    const double distance = (surface.centroids[t] - centroids[p] / areas[p]).squaredNorm();
    if (distance < best[p]) best[p] = distance, middle[p] = t;
  }
  std::vector<Seed> seeds;
  for (int p = 0; p < n; ++p) {
    if (middle[p] >= 0) seeds.push_back({middle[p], facing[p].stableNormalized()});
  }
  return seeds;
}

// The patches as a surface: sums over their pieces, and the borders between them.
SurfaceGraph GraphOfPatches(const SurfaceGraph& surface, const std::vector<int>& patch, int n) {
  SurfaceGraph graph;
  graph.centroids.assign(n, Eigen::Vector3d::Zero());
  graph.area_vectors.assign(n, Eigen::Vector3d::Zero());
  graph.areas.assign(n, 0.0);
  graph.at_border.assign(n, false);
  graph.size = surface.size;
  graph.area = surface.area;
  std::vector<Eigen::Vector3d> first_of(n);
  std::vector<int> count(n, 0);
  struct Border {
    int from, to;
    double length;
    Eigen::Vector3d moment;
  };
  std::vector<Border> borders;
  for (int t = 0; t < surface.n(); ++t) {
    const int p = patch[t];
    if (count[p]++ == 0) first_of[p] = surface.centroids[t];
    graph.centroids[p] += surface.areas[t] * surface.centroids[t];
    graph.area_vectors[p] += surface.area_vectors[t];
    graph.areas[p] += surface.areas[t];
    if (surface.at_border[t]) graph.at_border[p] = true;
    for (int k = surface.first[t]; k < surface.first[t + 1]; ++k) {
      const int q = patch[surface.to[k]];
      if (q != p) borders.push_back({p, q, surface.lengths[k], surface.lengths[k] * surface.middles[k]});
    }
  }
  for (int p = 0; p < n; ++p) {
    graph.centroids[p] = graph.areas[p] > 0.0 ? Eigen::Vector3d(graph.centroids[p] / graph.areas[p]) : first_of[p];
  }
  std::stable_sort(borders.begin(), borders.end(),
                   [](const Border& a, const Border& b) { return std::tie(a.from, a.to) < std::tie(b.from, b.to); });
  graph.first.assign(n + 1, 0);
  double apart = 0.0;
  for (std::size_t begin = 0; begin < borders.size();) {
    Border sum = borders[begin];
    std::size_t end = begin + 1;
    for (; end < borders.size() && borders[end].from == sum.from && borders[end].to == sum.to; ++end) {
      sum.length += borders[end].length;
      sum.moment += borders[end].moment;
    }
    begin = end;
    ++graph.first[sum.from + 1];
    graph.to.push_back(sum.to);
    graph.lengths.push_back(sum.length);
    const Eigen::Vector3d &a = graph.centroids[sum.from], &b = graph.centroids[sum.to];
    graph.middles.push_back(sum.length > 0.0 ? Eigen::Vector3d(sum.moment / sum.length)
                                             : Eigen::Vector3d(0.5 * (a + b)));
    apart += (b - a).norm();
  }
  std::partial_sum(graph.first.begin(), graph.first.end(), graph.first.begin());
  graph.edge = graph.to.empty() ? surface.edge : apart / static_cast<double>(graph.to.size());
  return graph;
}

}  // namespace

Patches MakePatches(const SurfaceGraph& surface, int wanted) {
  Patches patches;
  if (surface.n() < 2 * wanted) {
    patches.graph = surface;
    patches.of.resize(surface.n());
    std::iota(patches.of.begin(), patches.of.end(), 0);
    return patches;
  }
  const double patch_area = surface.area / wanted;
  const double width = std::sqrt(patch_area);
  int n = Grow(surface, FirstSeeds(surface, patch_area), width, patches.of);
  for (int step = 0; step < kLloydSteps; ++step) {
    n = Grow(surface, Middles(surface, patches.of, n, kLeastShare * patch_area), width, patches.of);
  }
  patches.graph = GraphOfPatches(surface, patches.of, n);
  return patches;
}

std::vector<double> MeanOfPatches(const SurfaceGraph& surface, const Patches& patches,
                                  const std::vector<double>& values) {
  const int n = patches.graph.n();
  std::vector<double> means(n, 0.0), plain(n, 0.0);
  std::vector<int> count(n, 0);
  for (int t = 0; t < surface.n(); ++t) {
    means[patches.of[t]] += surface.areas[t] * values[t];
    plain[patches.of[t]] += values[t];
    ++count[patches.of[t]];
  }
  for (int p = 0; p < n; ++p) {
    means[p] = patches.graph.areas[p] > 0.0 ? means[p] / patches.graph.areas[p] : plain[p] / count[p];
  }
  return means;
}

std::vector<int> LabelsOfPatches(const SurfaceGraph& surface, const Patches& patches, const std::vector<int>& labels) {
  std::vector<std::map<int, double>> areas(patches.graph.n());
  for (int t = 0; t < surface.n(); ++t) areas[patches.of[t]][labels[t]] += surface.areas[t];
  std::vector<int> result(patches.graph.n(), -1);
  for (int p = 0; p < patches.graph.n(); ++p) {
    double most = -1.0;
    for (const auto& [label, area] : areas[p]) {
      if (area > most) most = area, result[p] = label;
    }
  }
  return result;
}

}  // namespace geond
