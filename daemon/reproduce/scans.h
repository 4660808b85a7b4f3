// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/geon/fit.h"
#include "core/range/range_view.h"
#include "daemon/reproduce/experiment.h"
#include "sim/simulate_scan.h"

namespace geond::reproduce {

// How the simulated station looks at an object: four views round the table unless said otherwise (thesis 6.1).
struct ScanSettings {
  int views = 4;
  double first_angle = 0.0;   // rad
  double elevation = 0.489;   // rad over the table (28 degrees)
  double distance = 0.450;    // m
  double noise = 0.0002;      // m, along the ray
  std::uint64_t seed = 1;
};

// The views of a simulated scan, registered if there are several.
std::vector<RangeView> ScanViews(const sim::Scene& scene, const ScanSettings& settings, const Run& run);

// Their integrated data, thinned evenly to about `count` points, as the thesis thins 50 to 1 before it fits.
PointCloud ThinnedCloud(const std::vector<RangeView>& views, int count, const Run& run);

// Every type fitted to the data, in the order of the types; `chosen` is the place of the one that is taken.
struct SevenFits {
  std::array<GeonFit, 7> fits;
  int chosen = 0;
  // E of a type over that of another, m / m.
  double Ratio(int type, int of) const { return fits[type].objective / fits[of].objective; }
};

// By annealing alone with the thesis' settings, the least E chosen (the thesis' algorithm as repaired) ...
SevenFits FitByAnnealing(const PointCloud& cloud, const VfsrOptions& options, std::uint64_t seed, const Run& run);
// ... and by today's default.
SevenFits FitByDefault(const PointCloud& cloud, const Run& run);

// True if the first shape takes the form of the second when it is neither tapered nor bent: their residuals on data of the
// second
// are as good as equal (the underlined figures of Table 6.1).
bool Contains(GeonType larger, GeonType smaller);

// The geon over the points it was fitted to, 300 x 240 px.
Image FitPicture(const Geon& geon, const PointCloud& cloud, const Run& run);

// "tapered cylinder" for kTaperedCylinder.
std::string PlainName(GeonType type);

}  // namespace geond::reproduce
