// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "core/charge/charge_density.h"
#include "core/geometry/triangle_mesh.h"

namespace geond {

struct SegmentOptions {
  enum class Method {
    kWatershed,   // the default: watershed of the smoothed charge, merged and snapped by concavity
    kTrace,       // the thesis' boundary tracing and labelling (D.2, D.3), as repaired
    kThreshold,   // components above a share of the median charge (thesis Fig. 6.16 b)
  };
  Method method = Method::kWatershed;
  double detail = 0.5;       // 0 coarse to 1 fine: how weak a concavity still cuts
  double noise = 0.0;        // m, standard deviation of the vertices along the normal, if known
  double threshold = 0.75;   // kThreshold: of the median
  double trace_limit = 1.2;  // kTrace: rho_t over the minimum (correction 23)
};

// A cut between two parts.
struct PartBoundary {
  int a = 0, b = 0;        // parts, a < b
  double length = 0.0;     // m
  bool closed = false;     // the edges form closed loops
  double strength = 0.0;   // mean signed concavity along it, 0 flat, towards 1 sharp
};

struct PartSegmentation {
  int n_parts = 0;
  std::vector<int> labels;            // a triangle: 0 <= part < n_parts, largest area first; -1 none
  std::vector<PartBoundary> boundaries;
  std::vector<double> significance;   // a part: 0 to 1, its protrusion by charge
  std::string message;                // what was decided, in words
};

// Cuts a closed mesh into parts at deep concavities, where charge is least (thesis 4.7; METHOD 12). `charge` must be of
// this mesh. Deterministic; ties are broken by geometry. Throws std::invalid_argument if sizes do not fit, and Cancelled.
PartSegmentation SegmentParts(const TriangleMesh& mesh, const ChargeDensity& charge,
                              const SegmentOptions& options = {}, std::stop_token stop = {});

}  // namespace geond
