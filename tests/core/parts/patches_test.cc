// SPDX-License-Identifier: Apache-2.0
#include "core/parts/patches.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "core/parts/part_surface.h"
#include "core/parts/segment.h"

namespace geond {
namespace {

// A string of beads with thin necks, `rings` rings of triangles; the charge taken as the thickness.
void MakeBeads(int beads, int rings, TriangleMesh& mesh, ChargeDensity& charge) {
  const int around = rings / 4;
  const auto radius = [&](double u) { return 0.02 + std::abs(std::sin(beads * std::numbers::pi * u)); };
  for (int i = 0; i <= rings; ++i) {
    const double u = static_cast<double>(i) / rings;
    for (int k = 0; k < around; ++k) {
      const double a = 2.0 * std::numbers::pi * k / around;
      mesh.vertices.emplace_back(radius(u) * std::cos(a), radius(u) * std::sin(a), 1.75 * beads * u);
    }
  }
  for (int i = 0; i < rings; ++i) {
    for (int k = 0; k < around; ++k) {
      const int a = i * around + k, b = i * around + (k + 1) % around;
      mesh.triangles.push_back({a, b, a + around});
      mesh.triangles.push_back({b, b + around, a + around});
    }
  }
  for (int t = 0; t < static_cast<int>(mesh.triangles.size()); ++t) {
    charge.density.push_back(0.1 + radius(TriangleCentroid(mesh, t).z() / (1.75 * beads)));
  }
}

TEST(MakePatches, KeepsSumsAndBorders) {
  TriangleMesh mesh;
  ChargeDensity charge;
  MakeBeads(3, 120, mesh, charge);
  const PartSurface surface = MakePartSurface(mesh, 0.0);
  const Patches patches = MakePatches(surface.graph, 500);
  ASSERT_EQ(patches.of.size(), mesh.triangles.size());
  EXPECT_GT(patches.graph.n(), 250);
  EXPECT_LT(patches.graph.n(), 1000);
  double area = 0.0, border = 0.0;
  Eigen::Vector3d closed = Eigen::Vector3d::Zero();
  for (int p = 0; p < patches.graph.n(); ++p) {
    area += patches.graph.areas[p];
    closed += patches.graph.area_vectors[p];
    EXPECT_GT(patches.graph.areas[p], 0.0);
    for (int k = patches.graph.first[p]; k < patches.graph.first[p + 1]; ++k) {
      border += patches.graph.lengths[k];
      const auto back = patches.graph.Neighbors(patches.graph.to[k]);
      EXPECT_NE(std::find(back.begin(), back.end(), p), back.end());
    }
  }
  EXPECT_NEAR(area, surface.graph.area, 1e-9 * area);
  Eigen::Vector3d whole = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& v : surface.graph.area_vectors) whole += v;
  EXPECT_LT((closed - whole).norm(), 1e-9 * area);
  double expected = 0.0;
  for (int t = 0; t < surface.n(); ++t) {
    for (int k = surface.graph.first[t]; k < surface.graph.first[t + 1]; ++k) {
      if (patches.of[t] != patches.of[surface.graph.to[k]]) expected += surface.graph.lengths[k];
    }
  }
  EXPECT_NEAR(border, expected, 1e-9 * expected);
}

TEST(MakePatches, LeavesCoarseMeshesAsTheyAre) {
  TriangleMesh mesh;
  ChargeDensity charge;
  MakeBeads(2, 40, mesh, charge);
  const PartSurface surface = MakePartSurface(mesh, 0.0);
  const Patches patches = MakePatches(surface.graph, surface.n() / 2 + 1);
  EXPECT_EQ(patches.graph.n(), surface.n());
  const std::vector<double> means = MeanOfPatches(surface.graph, patches, surface.graph.areas);
  for (int t = 0; t < surface.n(); ++t) EXPECT_DOUBLE_EQ(means[t], surface.graph.areas[t]);
}

TEST(MakePatches, LabelsGoThereAndBack) {
  TriangleMesh mesh;
  ChargeDensity charge;
  MakeBeads(2, 120, mesh, charge);
  const PartSurface surface = MakePartSurface(mesh, 0.0);
  const Patches patches = MakePatches(surface.graph, 400);
  std::vector<int> labels(surface.n());
  for (int t = 0; t < surface.n(); ++t) labels[t] = patches.of[t] % 7;
  const std::vector<int> of_patches = LabelsOfPatches(surface.graph, patches, labels);
  for (int p = 0; p < patches.graph.n(); ++p) EXPECT_EQ(of_patches[p], p % 7);
}

// The same string, meshed so finely that it is cut in patches, which are wider than its necks.
TEST(SegmentParts, CutsAFineMeshAsACoarseOne) {
  for (int rings : {100, 320}) {
    TriangleMesh mesh;
    ChargeDensity charge;
    MakeBeads(4, rings, mesh, charge);
    const PartSegmentation parts = SegmentParts(mesh, charge);
    EXPECT_EQ(parts.n_parts, 4) << rings;
    ASSERT_EQ(parts.boundaries.size(), 3u) << rings;
    for (const PartBoundary& boundary : parts.boundaries) {
      EXPECT_TRUE(boundary.closed);
      EXPECT_LT(boundary.length, 0.5);
      EXPECT_GT(boundary.strength, 0.5);
    }
  }
}

}  // namespace
}  // namespace geond
