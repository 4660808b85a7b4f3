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
    kWatershed,  // the default: watershed of the averaged charge, merged where nobody would cut
    kTrace,      // the thesis' boundary tracing and labelling (D.2, D.3), as repaired
    kThreshold,  // components above a share of the median charge (thesis Fig. 6.16 b)
  };
  Method method = Method::kWatershed;
  double detail = 0.5;       // 0 coarse to 1 fine: how doubtful a cut is still made
  double noise = 0.0;        // m, standard deviation of the vertices along the normal, if known; 0: estimated
  double threshold = 0.75;   // kThreshold: of the median
  double trace_limit = 1.2;  // kTrace: rho_t over the minimum (correction 23)
};

// A cut between two parts.
struct PartBoundary {
  int a = 0, b = 0;     // parts, a < b
  double length = 0.0;  // m
  bool closed = false;  // the edges form closed loops
  // How likely a person would cut here, 0 to 1, by charge, concavity and closure: weak cuts may be ignored.
  double strength = 0.0;
  double concavity = 0.0;  // mean signed concavity along it, 0 flat, towards 1 sharp; a ridge counts as -0.1 at most
  double contrast =
      0.0;  // how far the charge along it lies below the mean of the lesser part: 0 not at all, 1 none left
};

struct PartSegmentation {
  int n_parts = 0;
  std::vector<int> labels;  // a triangle: 0 <= part < n_parts, largest area first; -1 none (a speck apart)
  std::vector<PartBoundary> boundaries;
  std::vector<double>
      significance;     // a part: 0 to 1, its protrusion by charge (one minus charge at its cuts over its top)
  std::string message;  // what was decided, in words
};

// Cuts a mesh into parts at deep concavities, where charge is least (thesis 4.7): every triangle in one part (but for
// specks apart from the rest, below 1 % of the area), each part in one piece. An open mesh (the seen surface of one
// view) is cut up to its border. `charge` must be of this mesh. The numbering of the input does not matter: ties are
// broken by geometry. Throws std::invalid_argument if sizes do not fit or an option is out of range, and Cancelled.
PartSegmentation SegmentParts(const TriangleMesh& mesh, const ChargeDensity& charge, const SegmentOptions& options = {},
                              std::stop_token stop = {});

}  // namespace geond
