// SPDX-License-Identifier: Apache-2.0
// What is told about boundaries and parts.
#include "core/parts/part_report.h"

#include <algorithm>
#include <map>
#include <utility>

#include "core/parts/concavity.h"
#include "core/parts/part_merge.h"

namespace geond {

std::vector<PartBoundary> ReportBoundaries(const PartSurface& surface, const std::vector<int>& labels,
                                           const std::vector<double>& averaged) {
  // How often each vertex ends an edge of a boundary: closed loops have even counts alone.
  std::map<std::pair<int, int>, std::map<int, int>> ends;
  for (const SurfaceEdge& edge : CollectEdges(surface, [&](int t, int u) { return labels[t] != labels[u]; })) {
    const std::pair<int, int> pair = std::minmax(labels[edge.triangle], labels[edge.other]);
    const TriangleMesh::Triangle& t = surface.mesh.triangles[edge.triangle];
    ++ends[pair][t[edge.side]];
    ++ends[pair][t[(edge.side + 1) % 3]];
  }
  const int n_parts = labels.empty() ? 0 : 1 + *std::max_element(labels.begin(), labels.end());
  std::vector<double> charge_of(n_parts, 0.0), area_of(n_parts, 0.0);
  for (int t = 0; t < surface.n(); ++t) {
    if (labels[t] < 0) continue;
    charge_of[labels[t]] += surface.areas[t] * averaged[t];
    area_of[labels[t]] += surface.areas[t];
  }
  MergeSettings settings;
  settings.radius = std::max(0.04 * surface.size, 1.5 * surface.edge);
  settings.convex_clip = -1.0;
  std::vector<PartBoundary> boundaries;
  for (const RegionBoundary& region : MeasureBoundaries(surface, labels, averaged, settings)) {
    if (region.a < 0) continue;
    PartBoundary boundary;
    boundary.a = region.a;
    boundary.b = region.b;
    boundary.length = region.length;
    boundary.strength = region.strength();
    const auto& counts = ends[{region.a, region.b}];
    boundary.closed = std::all_of(counts.begin(), counts.end(), [](const auto& c) { return c.second % 2 == 0; });
    const double lesser = std::min(charge_of[region.a] / area_of[region.a], charge_of[region.b] / area_of[region.b]);
    if (lesser > 0.0 && region.length > 0.0) {
      boundary.contrast = std::clamp(1.0 - region.charge / region.length / lesser, -1.0, 1.0);
    }
    boundaries.push_back(boundary);
  }
  return boundaries;
}

std::vector<double> ReportSignificance(const PartSurface& surface, const std::vector<int>& labels, int n_parts,
                                       const std::vector<double>& averaged) {
  std::vector<double> length(n_parts, 0.0), charge(n_parts, 0.0), significance(n_parts, 1.0);
  for (const SurfaceEdge& edge : CollectEdges(surface, [&](int t, int u) { return labels[t] != labels[u]; })) {
    for (int part : {labels[edge.triangle], labels[edge.other]}) {
      if (part < 0) continue;
      length[part] += edge.length;
      charge[part] += 0.5 * edge.length * (averaged[edge.triangle] + averaged[edge.other]);
    }
  }
  std::vector<std::vector<std::pair<double, double>>> values(n_parts);  // charge, area
  std::vector<double> areas(n_parts, 0.0);
  for (int t = 0; t < surface.n(); ++t) {
    if (labels[t] < 0) continue;
    values[labels[t]].push_back({averaged[t], surface.areas[t]});
    areas[labels[t]] += surface.areas[t];
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
