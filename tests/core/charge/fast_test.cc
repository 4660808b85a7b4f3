// SPDX-License-Identifier: Apache-2.0
#include "core/charge/fast.h"

#include <gtest/gtest.h>

#include "tests/core/charge/shapes.h"

namespace geond::charge {
namespace {

// Small local solves see little of the body: without a coarse level each iteration would carry charge only so far.
TEST(SolveFast, TakesFewerIterationsWithACoarseLevelAndComesToTheSame) {
  const TriangleMesh mesh = shapes::Cube(28);
  const Panels panels = MakePanels(mesh);
  FastSettings settings = FastSettingsFor(5e-4, panels.size());
  settings.leaf_capacity = 8;
  settings.local_triangles = 16;
  settings.error = 1e-5;
  settings.coarse_triangles = 100;
  const UnitPotentialSolution with = SolveFast(mesh, panels, settings, 0, {}, {});
  settings.coarse_triangles = static_cast<int>(panels.size());
  const UnitPotentialSolution without = SolveFast(mesh, panels, settings, 0, {}, {});
  EXPECT_TRUE(with.summary.converged);
  EXPECT_LT(with.summary.iterations + 2, without.summary.iterations);
  EXPECT_LT(shapes::RelativeRms(mesh, with.x, without.x), 3e-5);
}

}  // namespace
}  // namespace geond::charge
