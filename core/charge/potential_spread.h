// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "core/charge/charge_density.h"
#include "core/geometry/triangle_mesh.h"

namespace geond {

// The potential of the charge at random points of the surface. On a conductor it is the same everywhere; the solve makes
// it so at the centroids alone, so this tells how well the mesh carries the charge. All for unit charge, 1/m.
struct PotentialSpreadResult {
  double mean = 0.0;
  double least = 0.0, most = 0.0;
  double relative_rms = 0.0;  // of the deviation from the mean
  int samples = 0;
};

// Takes `samples` points, evenly by area and set by the seed, and the exact integrals there: samples * triangles * 10 ns.
// Throws std::invalid_argument if the charge is not that of the mesh or samples < 1.
PotentialSpreadResult PotentialSpread(const TriangleMesh& mesh, const ChargeDensity& charge, std::uint64_t seed = 1,
                                      int samples = 1000);

}  // namespace geond
