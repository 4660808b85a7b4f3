// SPDX-License-Identifier: Apache-2.0
#include "core/charge/potential_spread.h"

#include <stdexcept>

#include <gtest/gtest.h>

#include "tests/core/charge/shapes.h"

namespace geond {
namespace {

TEST(PotentialSpread, NarrowsAsTheMeshGrowsFinerAndLiesAroundThePotential) {
  const TriangleMesh coarse = shapes::Sphere(1), fine = shapes::Sphere(3);
  const ChargeDensity on_coarse = SolveChargeDensity(coarse), on_fine = SolveChargeDensity(fine);
  const PotentialSpreadResult wide = PotentialSpread(coarse, on_coarse), narrow = PotentialSpread(fine, on_fine);
  EXPECT_EQ(wide.samples, 1000);
  EXPECT_LT(narrow.relative_rms, 0.5 * wide.relative_rms);
  EXPECT_GT(narrow.relative_rms, 0.0);
  EXPECT_NEAR(narrow.mean / on_fine.potential, 1.0, 0.01);
  EXPECT_LT(narrow.least, narrow.mean);
  EXPECT_GT(narrow.most, narrow.mean);
}

TEST(PotentialSpread, IsSetByItsSeed) {
  const TriangleMesh mesh = shapes::Cube(4);
  const ChargeDensity charge = SolveChargeDensity(mesh);
  EXPECT_EQ(PotentialSpread(mesh, charge, 5, 100).relative_rms, PotentialSpread(mesh, charge, 5, 100).relative_rms);
  EXPECT_NE(PotentialSpread(mesh, charge, 5, 100).mean, PotentialSpread(mesh, charge, 6, 100).mean);
}

TEST(PotentialSpread, RefusesTheChargeOfAnotherMesh) {
  const ChargeDensity charge = SolveChargeDensity(shapes::Cube(2));
  EXPECT_THROW(PotentialSpread(shapes::Cube(3), charge), std::invalid_argument);
  EXPECT_THROW(PotentialSpread(shapes::Cube(2), charge, 1, 0), std::invalid_argument);
}

}  // namespace
}  // namespace geond
