// SPDX-License-Identifier: Apache-2.0
// The default segmentation: gate for single parts, watershed, merge, snap, merge again.
#include "core/parts/watershed_parts.h"

#include <algorithm>
#include <cmath>

#include "core/base/progress.h"
#include "core/parts/hull_depth.h"
#include "core/parts/part_merge.h"
#include "core/parts/part_snap.h"
#include "core/parts/watershed.h"

namespace geond {
namespace {

// 0 for a smooth surface to 1 for one whose noise asks for all that widens lengths.
double Roughness(const SurfaceGraph& surface, double noise, const WatershedSettings& settings) {
  if (!(surface.edge > 0.0)) return 0.0;
  return std::clamp((noise / surface.edge - settings.smooth_at) / (settings.rough_at - settings.smooth_at), 0.0, 1.0);
}

}  // namespace

WatershedSettings SettingsForDetail(double detail) {
  constexpr double kCoarsestOdds = 6.0, kFinestOdds = -1.0, kCoarsestArea = 0.1, kFinestArea = 0.0025;
  WatershedSettings settings;
  if (detail < 0.5) {
    const double coarse = 1.0 - 2.0 * detail;
    for (double step : {0.25, 0.5, 0.75, 1.0}) settings.snapped_odds.push_back(step * coarse * kCoarsestOdds);
    settings.small_area += (kCoarsestArea - settings.small_area) * coarse;
  } else if (detail > 0.5) {
    const double fine = 2.0 * detail - 1.0;
    std::erase_if(settings.snapped_odds, [&](double odds) { return odds > fine * kFinestOdds; });
    settings.snapped_odds.push_back(fine * kFinestOdds);
    settings.small_area += (kFinestArea - settings.small_area) * fine;
  }
  return settings;
}

int SmoothingSteps(const PartSurface& surface, const WatershedSettings& settings) {
  if (!(surface.graph.edge > 0.0)) return 0;
  const double rough = surface.noise / surface.graph.edge - settings.smooth_beyond;
  return static_cast<int>(std::ceil(settings.smoothing * std::max(0.0, rough)));
}

std::vector<int> SegmentByWatershed(const SurfaceGraph& surface, const std::vector<double>& charge, double noise,
                                    const WatershedSettings& settings, std::string& message, std::stop_token stop) {
  const double size = surface.size;
  if (!(size > 0.0)) {
    message = "no area: one part";
    return std::vector<int>(surface.n(), 0);
  }
  const double rough = Roughness(surface, noise, settings);
  const double radius = std::max(settings.concavity_radius * size,
                                 (settings.radius_in_edges + rough * settings.rough_edges) * surface.edge);
  const double depth = GreatestHullDepth(surface, radius);
  if (depth < settings.gate * size + settings.gate_noise * noise) {
    message = "convex within its noise: one part";
    return std::vector<int>(surface.n(), 0);
  }
  const std::vector<double> height = BallMean(
      surface, charge, std::max((settings.charge_radius + rough * settings.rough_charge_radius) * size, surface.edge));
  std::vector<int> labels = Watershed(surface, height);
  ThrowIfStopped(stop);

  MergeSettings merge;
  merge.radius = radius;
  merge.noise = noise;
  merge.on_measured = settings.on_measured;
  merge.log_odds = settings.rough_odds;
  MergeRegions(surface, height, merge, labels, stop);
  SnapSettings snap;
  snap.radius = std::max(settings.snap_radius * size, surface.edge);
  snap.band = std::max(settings.snap_band * size, 2.0 * surface.edge);
  snap.scale = settings.snap_scale;
  SnapBoundaries(surface, snap, labels, stop);
  merge.stage = CutStage::kSnapped;
  merge.log_odds = settings.snapped_odds;
  merge.small_area = settings.small_area;
  merge.small_charge = settings.small_charge;
  MergeRegions(surface, height, merge, labels, stop);
  message = *std::max_element(labels.begin(), labels.end()) > 0
                ? "cut where a person would: concave, of little charge, around parts closed in themselves"
                : "nothing divides it: one part";
  return labels;
}

}  // namespace geond
