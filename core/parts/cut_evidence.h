// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

#include <Eigen/Core>

namespace geond {

// What is known of a region of the surface: sums over its pieces, so that joining two is adding them.
struct SurfaceRegion {
  double area = 0.0;                                      // m^2
  Eigen::Vector3d area_vector = Eigen::Vector3d::Zero();  // m^2
  double charge = 0.0;                                    // averaged density times area
  double peak = 0.0;                                      // greatest averaged density
  double rim = 0.0;                                       // m, length of its borders with other regions
};

// What is measured along the border of two regions: sums by length.
struct RegionBorder {
  double length = 0.0;     // m
  double concavity = 0.0;  // length times signed concavity, clipped at -0.1
  double concave = 0.0;    // m, above 0.05
  double deep = 0.0;       // m, above 0.2
  double convex = 0.0;     // m, below -0.05
  double charge = 0.0;     // length times averaged density
  double pass = 0.0;       // greatest averaged density at which one may cross

  // Adds a piece of border; `charge_a`, `charge_b` are the densities on its two sides.
  void Add(double piece_length, double piece_concavity, double charge_a, double charge_b);
  void Add(const RegionBorder& other);
  double mean_concavity() const { return length > 0.0 ? concavity / length : 0.0; }
};

// Of the whole surface, for what regions are compared with.
struct SurfaceScale {
  double area = 0.0;     // m^2
  double density = 0.0;  // mean averaged density
  double noise = 0.0;    // standard deviation of the vertices over the radius of pooling
};

// What speaks for and against a cut between regions a and b, free of scale; the order is that of the weights.
using CutEvidence = std::array<double, 18>;
CutEvidence EvidenceForCut(const SurfaceRegion& a, const SurfaceRegion& b, const RegionBorder& border,
                           const SurfaceScale& scale);

// Of the evidence: how far the charge along the border lies under the mean of the lesser region, 0 not at all, 1 none.
double ContrastOf(const CutEvidence& evidence);

// How far regions have been worked out: as the watershed left them, or with their borders drawn to creases.
enum class CutStage { kRough, kSnapped };

// The logarithm of the odds that a person cuts there: above 0 more likely than not.
double LogOddsOfCut(const CutEvidence& evidence, CutStage stage);

}  // namespace geond
