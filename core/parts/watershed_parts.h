// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stop_token>
#include <string>
#include <vector>

#include "core/parts/part_merge.h"
#include "core/parts/part_surface.h"

namespace geond {

// The lengths and thresholds of the default method. Lengths are shares of the surface's size.
struct WatershedSettings {
  double smoothing = 30.0;                               // pairs of Taubin steps for each noise of one edge
  double smooth_beyond = 0.1;                            // noise over edge that needs none
  double gate = 0.012;                                   // a single part if no deeper under its hull than this, plus
  double gate_noise = 1.0;                               // this times the noise
  double charge_radius = 0.025;                          // over which the charge is averaged
  double concavity_radius = 0.04;                        // over which concavity is pooled, and
  double radius_in_edges = 1.5;                          // no less than this many edges
  double smooth_at = 0.05, rough_at = 0.17;              // noise over edge from which, and at which in full, is added
  double rough_edges = 0.6;                              // to radius_in_edges
  double rough_charge_radius = 0.01;                     // to charge_radius
  std::vector<double> rough_odds = {-3.0, -2.0, -1.0};   // log odds of cuts that are dissolved, in turn: as the
  std::vector<double> snapped_odds = {-1.0, -0.5, 0.0};  // watershed left them, and drawn to creases
  double small_area = 0.01;                              // least share of the area that makes a part
  double small_charge = 0.005;                           // and of the charge: the floor of a cup bears next to none
  double snap_radius = 0.03;                             // over which concavity is pooled for the cuts
  double snap_band = 0.08;                               // how far a cut may move
  double snap_scale = 0.06;                              // of concavity in the cost of a cut
  int patches = 5000;                                    // finer meshes are cut in patches, then along their triangles
  double fine_radius = 0.012;                            // over which concavity is pooled for the latter
  // For those who want to look on: see MergeSettings.
  decltype(MergeSettings::on_measured) on_measured;
};

// The settings for a `detail` from 0 (coarse) over 0.5 (the defaults) to 1 (fine): how far up the tree of merges to go.
// What is coarse is made of whole parts of what is less coarse, but for parts too small to stand alone.
WatershedSettings SettingsForDetail(double detail);

// The pairs of Taubin's steps that a surface of this noise needs before it is cut.
int SmoothingSteps(const PartSurface& surface, const WatershedSettings& settings);

// Parts by a watershed of the averaged charge, merged where nobody would cut, with cuts drawn to creases.
// Labels in the order of the surface. `noise` as in PartSurface. `message` says what was decided.
std::vector<int> SegmentByWatershed(const SurfaceGraph& surface, const std::vector<double>& charge, double noise,
                                    const WatershedSettings& settings, std::string& message, std::stop_token stop = {});

}  // namespace geond
