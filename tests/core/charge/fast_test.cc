// SPDX-License-Identifier: Apache-2.0
#include "core/charge/fast.h"

#include <gtest/gtest.h>

#include "tests/core/charge/shapes.h"

namespace geond::charge {
namespace {

// Small local solves see little of the body: without a coarse level each iteration would carry charge only so far.
TEST(SolveFast, TakesFewerIterationsWithACoarseLevelAndComesToTheSame) {
  const TriangleMesh mesh = shapes::Cube(20);
  const Panels panels = MakePanels(mesh);
  FastSettings settings = FastSettingsFor(1e-6, panels.size());
  settings.leaf_capacity = 8;
  settings.halo = 8;
  settings.coarse_triangles = 100;
  const UnitPotentialSolution with = SolveFast(mesh, panels, settings, 0, {}, {});
  settings.coarse_triangles = static_cast<int>(panels.size());
  const UnitPotentialSolution without = SolveFast(mesh, panels, settings, 0, {}, {});
  EXPECT_TRUE(with.summary.converged);
  EXPECT_LT(with.summary.iterations + 2, without.summary.iterations);
  EXPECT_LT(shapes::RelativeRms(mesh, with.x, without.x), 2e-6);
}

}  // namespace
}  // namespace geond::charge
