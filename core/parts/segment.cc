// SPDX-License-Identifier: Apache-2.0
// The front of the room: checks, method, and what is told about parts and boundaries.
#include "core/parts/segment.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <stdexcept>
#include <string>

#include "core/base/progress.h"
#include "core/parts/part_report.h"
#include "core/parts/part_snap.h"
#include "core/parts/part_surface.h"
#include "core/parts/patches.h"
#include "core/parts/trace.h"
#include "core/parts/unseen_cuts.h"
#include "core/parts/watershed_parts.h"

namespace geond {
namespace {

// Specks: pieces of the mesh without connection to a part, below 1 % of the area. They belong to no part.
void DropSpecks(const SurfaceGraph& surface, std::vector<int>& labels) {
  const int n = 1 + *std::max_element(labels.begin(), labels.end());
  std::vector<double> areas(n, 0.0);
  std::vector<bool> alone(n, true);
  for (int t = 0; t < surface.n(); ++t) {
    areas[labels[t]] += surface.areas[t];
    for (int next : surface.Neighbors(t)) {
      if (labels[next] != labels[t]) alone[labels[t]] = false;
    }
  }
  const double greatest = *std::max_element(areas.begin(), areas.end());
  for (int& label : labels) {
    if (alone[label] && areas[label] < std::min(0.01 * surface.area, greatest)) label = -1;
  }
}

// Renumbers labels by area, the largest first; equal areas by the order of the surface.
int OrderByArea(const SurfaceGraph& surface, std::vector<int>& labels) {
  std::map<int, double> areas;
  for (int t = 0; t < surface.n(); ++t) {
    if (labels[t] >= 0) areas[labels[t]] += surface.areas[t];
  }
  std::vector<int> order;
  for (const auto& [label, area] : areas) order.push_back(label);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return areas[a] > areas[b]; });
  std::map<int, int> rank;
  for (std::size_t i = 0; i < order.size(); ++i) rank[order[i]] = static_cast<int>(i);
  for (int& label : labels) label = label < 0 ? label : rank[label];
  return static_cast<int>(order.size());
}

// The default: on patches of the smoothed surface, then along its triangles.
std::vector<int> CutByWatershed(PartSurface& surface, const std::vector<double>& density, double detail,
                                std::string& message, Patches& patches, std::stop_token stop) {
  const WatershedSettings settings = SettingsForDetail(detail);
  SmoothTaubin(surface, SmoothingSteps(surface, settings));
  patches = MakePatches(surface.graph, settings.patches);
  ThrowIfStopped(stop);
  const std::vector<int> coarse = SegmentByWatershed(patches.graph, MeanOfPatches(surface.graph, patches, density),
                                                     surface.noise, settings, message, stop);
  std::vector<int> labels(surface.n());
  for (int t = 0; t < surface.n(); ++t) labels[t] = coarse[patches.of[t]];
  if (patches.graph.n() < surface.n()) {
    SnapSettings snap;
    snap.radius = std::max(settings.fine_radius * surface.graph.size, 1.5 * surface.graph.edge);
    snap.band = 1.5 * patches.graph.edge;
    snap.scale = settings.snap_scale;
    SnapBoundaries(surface.graph, snap, labels, stop);
  }
  return labels;
}

}  // namespace

PartSegmentation SegmentParts(const TriangleMesh& mesh, const ChargeDensity& charge, const SegmentOptions& options,
                              std::stop_token stop) {
  CheckMesh(mesh);
  if (charge.density.size() != mesh.triangles.size()) {
    throw std::invalid_argument("SegmentParts: the charge has " + std::to_string(charge.density.size()) +
                                " values, the mesh " + std::to_string(mesh.triangles.size()) + " triangles");
  }
  PartSegmentation result;
  if (mesh.empty()) {
    result.message = "no triangles";
    return result;
  }
  if (!(options.detail >= 0.0 && options.detail <= 1.0)) {
    throw std::invalid_argument("SegmentParts: detail must lie between 0 (coarse) and 1 (fine)");
  }
  if (!(options.noise >= 0.0)) throw std::invalid_argument("SegmentParts: noise must not be negative");
  PartSurface surface = MakePartSurface(mesh, options.noise > 0.0 ? options.noise : -1.0);
  std::vector<double> density(surface.n());
  for (int t = 0; t < surface.n(); ++t) {
    density[t] = charge.density[surface.source[t]];
    if (!std::isfinite(density[t])) {
      throw std::invalid_argument("SegmentParts: the charge of triangle " + std::to_string(surface.source[t]) +
                                  " is not finite");
    }
  }
  ThrowIfStopped(stop);

  std::vector<int> labels;
  Patches patches;
  switch (options.method) {
    case SegmentOptions::Method::kWatershed:
      labels = CutByWatershed(surface, density, options.detail, result.message, patches, stop);
      break;
    case SegmentOptions::Method::kTrace:
      labels = SegmentByTracing(surface.graph, density, options.trace_limit);
      result.message = "boundaries traced along valleys of the charge";
      break;
    case SegmentOptions::Method::kThreshold:
      labels = SegmentByThreshold(surface.graph, density, options.threshold);
      result.message = "components above a share of the median charge";
      break;
  }
  if (patches.of.empty()) patches = MakePatches(surface.graph, WatershedSettings().patches);
  if (!mesh.triangle_seen.empty()) {
    std::vector<std::uint8_t> seen(surface.n());
    for (int t = 0; t < surface.n(); ++t) seen[t] = mesh.triangle_seen.at(surface.source[t]);
    JoinOverUnseen(surface.graph, seen, labels);
  }
  DropSpecks(surface.graph, labels);
  result.n_parts = OrderByArea(surface.graph, labels);
  result.labels.assign(mesh.triangles.size(), -1);
  for (int t = 0; t < surface.n(); ++t) result.labels[surface.source[t]] = labels[t];
  const std::vector<double> averaged = BallMean(patches.graph, MeanOfPatches(surface.graph, patches, density),
                                                std::max(0.025 * patches.graph.size, patches.graph.edge));
  result.boundaries = ReportBoundaries(surface, labels, patches, averaged);
  result.significance = ReportSignificance(surface, labels, result.n_parts, patches, averaged);
  return result;
}

}  // namespace geond
