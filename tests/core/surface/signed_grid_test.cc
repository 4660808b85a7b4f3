// SPDX-License-Identifier: Apache-2.0
#include "core/surface/signed_grid.h"

#include <cmath>
#include <numbers>
#include <random>
#include <stdexcept>

#include <gtest/gtest.h>

namespace geond {
namespace {

SignedGrid Filled(const Eigen::AlignedBox3d& box, double step, const auto& f) {
  SignedGrid grid(box, step, 1.0f);
  for (int k = 0; k < grid.size[2]; ++k) {
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i) grid.value[grid.index(i, j, k)] = static_cast<float>(f(grid.node(i, j, k)));
    }
  }
  return grid;
}

const Eigen::AlignedBox3d kBox(Eigen::Vector3d(-1.1, -1.1, -1.1), Eigen::Vector3d(1.1, 1.1, 1.1));

TEST(SignedGrid, SamplesALinearFieldExactly) {
  const SignedGrid grid = Filled(kBox, 0.25, [](const Eigen::Vector3d& p) { return 1.0 + p.dot(Eigen::Vector3d(2, -3, 4)); });
  for (const Eigen::Vector3d& p : {Eigen::Vector3d(0.1, 0.2, 0.3), Eigen::Vector3d(-0.77, 1.0, 0.5)}) {
    Eigen::Vector3d gradient;
    EXPECT_NEAR(grid.Sample(p, &gradient), 1.0 + p.dot(Eigen::Vector3d(2, -3, 4)), 1e-5);
    EXPECT_LT((gradient - Eigen::Vector3d(2, -3, 4)).norm(), 1e-4);
  }
}

TEST(SignedGrid, HasANodeLayerOnTheTable) {
  const SignedGrid grid(Eigen::AlignedBox3d(Eigen::Vector3d(0.01, 0.02, 0.003), Eigen::Vector3d(0.1, 0.1, 0.05)), 0.0017, 1.0f);
  const double layers = -grid.origin.z() / grid.step;
  EXPECT_NEAR(layers, std::round(layers), 1e-9);
  EXPECT_THROW(SignedGrid(kBox, 1e-6, 1.0f), std::invalid_argument);
}

TEST(MarchingTetrahedra, ASphereIsASphere) {
  const TriangleMesh mesh = MarchingTetrahedra(Filled(kBox, 0.05, [](const Eigen::Vector3d& p) { return p.norm() - 0.9; }));
  const MeshTopology topology = Topology(mesh);
  EXPECT_TRUE(topology.closed && topology.manifold);
  EXPECT_EQ(topology.genus, 0);
  EXPECT_EQ(topology.components, 1);
  EXPECT_NEAR(Volume(mesh), 4.0 / 3.0 * std::numbers::pi * 0.729, 0.01);
  for (const Eigen::Vector3d& v : mesh.vertices) EXPECT_NEAR(v.norm(), 0.9, 2e-3);
}

TEST(MarchingTetrahedra, ATorusHasOneHole) {
  const TriangleMesh mesh = MarchingTetrahedra(Filled(kBox, 0.07, [](const Eigen::Vector3d& p) {
    return std::hypot(std::hypot(p.x(), p.y()) - 0.6, p.z()) - 0.25;
  }));
  EXPECT_TRUE(Topology(mesh).manifold);
  EXPECT_EQ(Topology(mesh).genus, 1);
}

TEST(MarchingTetrahedra, WhateverTheSignsTheSurfaceIsAClosedManifoldTurnedOutward) {
  std::mt19937 random(7);
  for (int round = 0; round < 20; ++round) {
    SignedGrid grid(kBox, 0.4, 1.0f);
    for (int k = 1; k + 1 < grid.size[2]; ++k) {
      for (int j = 1; j + 1 < grid.size[1]; ++j) {
        for (int i = 1; i + 1 < grid.size[0]; ++i) {
          grid.value[grid.index(i, j, k)] = static_cast<float>(random() % 5) - 2.0f;  // with exact zeros
        }
      }
    }
    const TriangleMesh mesh = MarchingTetrahedra(grid);
    const MeshTopology topology = Topology(mesh);
    EXPECT_TRUE(topology.closed);
    EXPECT_TRUE(topology.manifold);
    EXPECT_GT(Volume(mesh), 0.0);
  }
}

}  // namespace
}  // namespace geond
