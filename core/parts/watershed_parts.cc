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

WatershedSettings SettingsForDetail(double detail) {
  WatershedSettings settings;
  if (detail < 0.5) {
    const double coarse = 1.0 - 2.0 * detail;
    settings.coarse_threshold = settings.final_threshold + 0.3 * coarse;
    settings.coarse_area = settings.small_area + 0.09 * coarse;
  } else if (detail > 0.5) {
    const double scale = std::exp2(1.0 - 2.0 * detail);
    settings.gate *= scale;
    settings.charge_radius *= scale;
    settings.concavity_radius *= scale;
    settings.first_threshold *= scale;
    settings.final_threshold *= scale;
    settings.small_area *= scale * scale;
    settings.snap_radius *= scale;
    settings.snap_band *= scale;
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
  const double radius = std::max(settings.concavity_radius * size, settings.radius_in_edges * surface.edge);
  const double depth = GreatestHullDepth(surface, radius);
  if (depth < settings.gate * size + settings.gate_noise * noise) {
    message = "convex within its noise: one part";
    return std::vector<int>(surface.n(), 0);
  }
  const std::vector<double> height = BallMean(surface, charge, std::max(settings.charge_radius * size, surface.edge));
  std::vector<int> labels = Watershed(surface, height);
  ThrowIfStopped(stop);

  MergeSettings merge;
  merge.radius = radius;
  merge.small_area = settings.small_area;
  merge.contrast_weight = settings.contrast_weight;
  merge.share_weight = settings.share_weight;
  const double doubt = settings.noise_threshold * noise / radius;
  SnapSettings snap;
  snap.radius = std::max(settings.snap_radius * size, surface.edge);
  snap.band = std::max(settings.snap_band * size, 2.0 * surface.edge);
  snap.scale = settings.snap_scale;
  merge.threshold = settings.first_threshold + doubt;
  MergeRegions(surface, height, merge, labels, stop);
  SnapBoundaries(surface, snap, labels, stop);
  merge.threshold = settings.final_threshold + doubt;
  MergeRegions(surface, height, merge, labels, stop);
  if (settings.coarse_threshold > 0.0) {
    merge.threshold = settings.coarse_threshold + doubt;
    merge.small_area = settings.coarse_area;
    MergeRegions(surface, height, merge, labels, stop);
  }
  message = *std::max_element(labels.begin(), labels.end()) > 0
                ? "cut where the surface is concave between charged regions"
                : "no concavity divides it: one part";
  return labels;
}

}  // namespace geond
