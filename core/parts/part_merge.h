// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <stop_token>
#include <vector>

#include "core/parts/cut_evidence.h"
#include "core/parts/surface_graph.h"

namespace geond {

// The border of two labels, and what speaks for a cut there.
struct CutCandidate {
  int a = 0, b = 0;  // a < b
  RegionBorder border;
  CutEvidence evidence{};
};

struct MergeSettings {
  double radius = 0.0;  // m, over which concavity is pooled
  double noise = 0.0;   // m, standard deviation of the vertices
  CutStage stage = CutStage::kRough;
  std::vector<double> log_odds;  // borders below the first are dissolved, the weakest first, then those below the next
  double small_area = 0.0;       // regions below this share of the area join the neighbour with the weakest border,
  double small_charge = 0.0;     // and so do those below this share of the charge
  // Told, if set, of the labels and candidates each time they are measured.
  std::function<void(const std::vector<int>& labels, const std::vector<CutCandidate>& candidates, CutStage stage)>
      on_measured;
};

// All borders between labels >= 0, in order of (a, b). `charge` a piece, averaged over balls.
std::vector<CutCandidate> MeasureCuts(const SurfaceGraph& surface, const std::vector<int>& labels,
                                      const std::vector<double>& charge, const MergeSettings& settings);

// Dissolves the borders that are hardly cuts, measuring anew for each of the levels; then small regions. Labels are
// numbered anew from 0 in the order of the surface.
void MergeRegions(const SurfaceGraph& surface, const std::vector<double>& charge, const MergeSettings& settings,
                  std::vector<int>& labels, std::stop_token stop = {});

}  // namespace geond
