// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <stop_token>
#include <vector>

#include "core/base/progress.h"
#include "core/base/solve_summary.h"
#include "core/geon/geon.h"
#include "core/geon/surroundings.h"
#include "core/geon/vfsr.h"
#include "core/geometry/point_cloud.h"

namespace geond {

// What the data say about one end of a geon, the surface across one half of one of G's axes.
enum class EndState {
  kSeen,     // there are points on it
  kBounded,  // no points, but places known to be empty not far beyond
  kHidden,   // nothing: the shape may go on there (the far side of a single view, a cut to a neighbour, the inside of one)
};
// Across -x +x, -y +y, -z +z of G.
using EndStates = std::array<std::array<EndState, 2>, 3>;

struct FitOptions {
  // Many starts refined by Levenberg-Marquardt, or the thesis' annealing alone (which finds the least objective of deformed
  // types in a small share of its runs).
  enum class Optimizer { kMultiStart, kVfsr };
  Optimizer optimizer = Optimizer::kMultiStart;
  VfsrOptions vfsr;
  std::vector<GeonType> types{kGeonTypes.begin(), kGeonTypes.end()};
  double lambda = 5.0;          // weight of the normals in E = t1 + lambda gamma t2 (5.18) when the model is chosen
  double search_lambda = 0.3;   // ... while searching
  double report_lambda = 0.2;   // ... when the reported parameters are refined
  double fallback_ratio = 1.20;      // a deformed winner falls back to its base type if
  double fallback_distance = 0.001;  // E_base <= fallback_ratio E + fallback_distance D, D the diagonal of the data, or if
  double fallback_errors = 3.0;      // E_base - E is below so many of its standard errors and
  double fallback_scatter_ratio = 1.30;  // E_base <= fallback_scatter_ratio E
  bool outline_of_one_view = true;  // of data seen from one side about which nothing else is known: what lies outside their
                                    // outline is taken for empty; false: the thesis' objective and nothing else
  // Keeps every start to the end, begins from more frames, and searches a second time, at ten times search_lambda: the least
  // objective of types that the data are not of as well, at some ten times the time.
  bool thorough = false;
  // Of the mean half size, as a share of the data's diagonal: a geon that shrinks to a point makes the normals' term vanish,
  // and on data that fit nothing well that would be the least objective. Rods and plates have 0.17; next to 0: as the thesis.
  double least_gamma = 0.1;
  int max_points = 1500;        // more are thinned, evenly and deterministically
  std::uint64_t seed = 1;       // of the annealing; the multi-start draws nothing at random
  int threads = 0;
};

// One type fitted to the data.
struct GeonFit {
  Geon geon;                    // canonical; of the first fit refined at report_lambda, of the others at lambda
  double residual = 0.0;        // mean first-order orthogonal distance to the surface, m (correction 11)
  double objective = 0.0;       // the least E at lambda, m, with the mean depth by which it covers empty places; what the
                                // types are compared by
  double t1 = 0.0;              // (5.19) there, m
  double t2 = 0.0;              // (5.24) there
  double confidence = 0.0;      // probability that the type is right, as calibrated on simulated scans; of the first fit only
  double margin = 0.0;          // least objective of another type, but for deformations of this one, over this
                                // one's; of the first fit only
  std::vector<double> deviation;  // standard deviations: position along G's axes 3 (m), rotation about them 3 (rad), size 3
                                  // (m), taper 2, bend (1/m), 0 where the type has none; infinite where the data do not say
  EndStates ends{};             // a size with a hidden end is what was seen of it, at least that much
  int points = 0;               // different, finite points with normals that were used
  int points_dropped = 0;       // ... and those that were not
  int outliers = 0;             // of the max_points that were fitted: on no surface with their neighbours, left out
  int evaluations = 0;          // of the objective
  SolveSummary summary;
};

// Fits every type asked for and orders them: the chosen one first, the others by objective. `part` needs outward unit
// normals; points that are not finite are dropped. A fit that covers empty places is the worse for it. Throws
// std::invalid_argument if fewer than 12 usable points or no normals, and Cancelled.
std::vector<GeonFit> FitGeons(const PointCloud& part, const FitOptions& options = {}, std::stop_token stop = {},
                              const StepObserver& on_step = {}, const Surroundings& around = {});

}  // namespace geond
