// SPDX-License-Identifier: Apache-2.0
// What is told about boundaries and parts.
#include "core/parts/part_report.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "core/parts/concavity.h"
#include "core/parts/part_merge.h"

namespace geond {

std::vector<PartBoundary> ReportBoundaries(const PartSurface& surface, const std::vector<int>& labels,
                                           const Patches& patches, const std::vector<double>& averaged) {
  const SurfaceGraph& graph = surface.graph;
  // How often each vertex ends an edge of a boundary: closed loops have even counts alone.
  std::map<std::pair<int, int>, PartBoundary> boundaries;
  std::map<std::pair<int, int>, std::map<int, int>> ends;
  for (const SurfaceEdge& edge : CollectEdges(graph, [&](int t, int u) { return labels[t] != labels[u]; })) {
    const std::pair<int, int> pair = std::minmax(labels[edge.from], labels[edge.to]);
    if (pair.first < 0) continue;
    for (int vertex : surface.arc_ends[edge.arc]) ++ends[pair][vertex];
    PartBoundary& boundary = boundaries[pair];
    boundary.a = pair.first;
    boundary.b = pair.second;
    boundary.length += graph.lengths[edge.arc];
  }
  for (auto& [pair, boundary] : boundaries) {
    boundary.closed = std::ranges::all_of(ends[pair], [](const auto& count) { return count.second % 2 == 0; });
  }

  MergeSettings settings;
  settings.radius = std::max(0.04 * patches.graph.size, 1.5 * patches.graph.edge);
  settings.noise = surface.noise;
  for (const CutCandidate& cut :
       MeasureCuts(patches.graph, LabelsOfPatches(graph, patches, labels), averaged, settings)) {
    const auto at = boundaries.find({cut.a, cut.b});
    if (at == boundaries.end()) continue;
    at->second.concavity = cut.border.mean_concavity();
    at->second.contrast = ContrastOf(cut.evidence);
    at->second.strength = 1.0 / (1.0 + std::exp(-LogOddsOfCut(cut.evidence, CutStage::kSnapped)));
  }
  std::vector<PartBoundary> list;
  for (const auto& [pair, boundary] : boundaries) list.push_back(boundary);
  return list;
}

std::vector<double> ReportSignificance(const PartSurface& surface, const std::vector<int>& labels, int n_parts,
                                       const Patches& patches, const std::vector<double>& averaged) {
  const SurfaceGraph& graph = surface.graph;
  std::vector<double> length(n_parts, 0.0), charge(n_parts, 0.0), significance(n_parts, 1.0);
  for (const SurfaceEdge& edge : CollectEdges(graph, [&](int t, int u) { return labels[t] != labels[u]; })) {
    for (int part : {labels[edge.from], labels[edge.to]}) {
      if (part < 0) continue;
      length[part] += graph.lengths[edge.arc];
      charge[part] += 0.5 * graph.lengths[edge.arc] * (averaged[patches.of[edge.from]] + averaged[patches.of[edge.to]]);
    }
  }
  std::vector<std::vector<std::pair<double, double>>> values(n_parts);  // charge, area
  std::vector<double> areas(n_parts, 0.0);
  for (int t = 0; t < graph.n(); ++t) {
    if (labels[t] < 0) continue;
    values[labels[t]].push_back({averaged[patches.of[t]], graph.areas[t]});
    areas[labels[t]] += graph.areas[t];
  }
  for (int part = 0; part < n_parts; ++part) {
    if (length[part] <= 0.0) continue;
    std::sort(values[part].begin(), values[part].end());
    double below = 0.0, top = 0.0;
    for (const auto& [value, area] : values[part]) {
      top = value;
      if ((below += area) >= 0.95 * areas[part]) break;
    }
    significance[part] = top > 0.0 ? std::clamp(1.0 - charge[part] / length[part] / top, 0.0, 1.0) : 0.0;
  }
  return significance;
}

}  // namespace geond
