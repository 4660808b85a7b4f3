// SPDX-License-Identifier: Apache-2.0
// How likely a border between two regions is a cut that a person would make.
#include "core/parts/cut_evidence.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <tuple>

namespace geond {
namespace {

constexpr double kConvexClip = -0.1;  // beyond, a ridge speaks no more strongly against a cut

// How far `low` lies under `high`: 0 not at all, 1 nothing left.
double Under(double low, double high) { return std::clamp(1.0 - low / high, -1.0, 1.0); }

}  // namespace

void RegionBorder::Add(double piece_length, double piece_concavity, double charge_a, double charge_b) {
  length += piece_length;
  concavity += piece_length * std::max(piece_concavity, kConvexClip);
  if (piece_concavity > 0.05) concave += piece_length;
  if (piece_concavity > 0.2) deep += piece_length;
  if (piece_concavity < -0.05) convex += piece_length;
  charge += 0.5 * piece_length * (charge_a + charge_b);
  pass = std::max(pass, std::min(charge_a, charge_b));
}

void RegionBorder::Add(const RegionBorder& other) {
  length += other.length;
  concavity += other.concavity;
  concave += other.concave;
  deep += other.deep;
  convex += other.convex;
  charge += other.charge;
  pass = std::max(pass, other.pass);
}

CutEvidence EvidenceForCut(const SurfaceRegion& a, const SurfaceRegion& b, const RegionBorder& border,
                           const SurfaceScale& scale) {
  const bool a_is_small = a.area < b.area;
  const SurfaceRegion &small = a_is_small ? a : b, &large = a_is_small ? b : a;
  const double small_density = small.charge / small.area, large_density = large.charge / large.area;
  const double lesser = std::min(small_density, large_density), lesser_peak = std::min(a.peak, b.peak);
  const double concavity = border.mean_concavity(), share = border.length / std::min(a.rim, b.rim);
  CutEvidence evidence = {
      1.0,
      concavity,
      border.concave / border.length,
      border.deep / border.length,
      Under(border.charge / border.length, lesser),
      Under(border.charge / border.length, lesser_peak),
      Under(border.pass, lesser_peak),
      (small_density - large_density) / (small_density + large_density),
      share,
      std::log(border.length / std::sqrt(4.0 * std::numbers::pi * small.area)),
      std::log(small.area / scale.area),
      scale.noise,
      std::log(lesser / scale.density),
      concavity * scale.noise,
      small.area_vector.norm() / small.area,
      large.area_vector.norm() / large.area,
      border.convex / border.length,
      concavity * share,
  };
  for (double& value : evidence) {
    if (!std::isfinite(value)) value = 0.0;  // no charge, no area, no length: no evidence
  }
  return evidence;
}

double ContrastOf(const CutEvidence& evidence) { return evidence[4]; }

double LogOddsOfCut(const CutEvidence& evidence, CutStage stage) {
  struct Weight {
    double rough, snapped;
  };
  // Fitted by logistic regression to what people and generators of objects hold apart; docs/parts.md says on which
  // data, tests/validation/parts_weights_validation.cc does it again.
  static constexpr std::array<Weight, std::tuple_size_v<CutEvidence>> kWeights = {{
      {-1.375, -2.008},     // always
      {4.245, 0.4541},      // mean concavity
      {1.434, 2.509},       // share of the border that is concave
      {1.14, 0.3937},       // share that is deeply so
      {0.8531, 0.7586},     // charge along the border under the lesser mean of the two
      {-0.7778, -0.1608},   // charge along the border under the lesser peak
      {0.633, 0.9543},      // charge at the border's highest pass under the lesser peak
      {-0.01705, 0.5235},   // the small region's density against the large one's
      {0.004269, 0.04644},  // share of the lesser rim
      {-0.2004, -0.8492},   // border against the rim of a flat disk of the small region's area
      {0.09828, 0.02266},   // the small region's share of the surface
      {-3.899, -5.319},     // noise over the radius of pooling
      {-0.3225, -0.1851},   // the lesser density against the mean
      {13.87, 20.23},       // concavity, noise
      {-0.8021, -1.475},    // how one-sided the small region is: 0 closed in itself, 1 flat
      {-0.8301, -3.184},    // the same of the large region
      {1.016, 2.614},       // share of the border that is a ridge
      {5.597, 4.157},       // concavity, share of the lesser rim
  }};
  double sum = 0.0;
  for (std::size_t i = 0; i < evidence.size(); ++i) {
    sum += evidence[i] * (stage == CutStage::kRough ? kWeights[i].rough : kWeights[i].snapped);
  }
  return sum;
}

}  // namespace geond
