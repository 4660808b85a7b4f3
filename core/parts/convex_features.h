// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "core/charge/charge_density.h"
#include "core/geometry/triangle_mesh.h"

namespace geond {

// Where a surface protrudes: charge gathers there (a grasp, a probe or a guard may want to know).
struct ConvexFeature {
  enum class Kind { kTip, kEdge };
  Kind kind = Kind::kTip;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();   // m: of a tip its top, of an edge its middle
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();  // unit: of a tip outward, of an edge along it
  double length = 0.0;                                  // m, greatest extent
  double strength = 0.0;  // charge density at the top over the median of the surface, above 1
  std::vector<int> triangles;
};

struct ConvexFeatureOptions {
  double radius = 0.02;    // over which charge is averaged, share of the surface's size
  double least = 1.6;      // density over the median by area that counts as high
  double least_top = 2.0;  // at the top of a feature
};

// Tips and edges of the surface by high charge density (the thesis names convexity as a use of charge beside cuts): the
// connected places where the averaged density exceeds `least` times the median, a hill of charge each; an edge where
// the place is more than three times as long as wide, else a tip. The strongest first. `charge` must be of this mesh.
// Throws std::invalid_argument if sizes do not fit.
std::vector<ConvexFeature> FindConvexFeatures(const TriangleMesh& mesh, const ChargeDensity& charge,
                                              const ConvexFeatureOptions& options = {});

}  // namespace geond
