// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

#include <gtest/gtest.h>

#include "core/surface/tessellate.h"
#include "tests/core/surface/views.h"

namespace geond {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

// Parallel rays, pitch 1 m; NaN where there is nothing.
RangeView Grid(int columns, std::vector<float> depth) {
  RangeView view;
  view.sensor.projection = SensorModel::Projection::kOrthographic;
  view.image.columns = view.sensor.columns = columns;
  view.image.rows = view.sensor.rows = static_cast<int>(depth.size()) / columns;
  for (float z : depth) view.classes.push_back(std::isfinite(z) ? PixelClass::kObject : PixelClass::kBackground);
  view.image.depth = std::move(depth);
  return view;
}

int CountSeen(const TriangleMesh& mesh) { return static_cast<int>(std::count(mesh.triangle_seen.begin(), mesh.triangle_seen.end(), 1)); }

void ExpectClosedOutward(const TriangleMesh& mesh, int genus = 0) {
  const MeshTopology topology = Topology(mesh);
  EXPECT_TRUE(topology.closed);
  EXPECT_TRUE(topology.manifold);
  EXPECT_EQ(topology.genus, genus);
  EXPECT_GT(Volume(mesh), 0.0);
}

TEST(TessellateView, AFullWindowGivesTwoTrianglesAndOneWithoutACornerOne) {
  EXPECT_EQ(CountSeen(TessellateView(Grid(2, {1, 1, 1, 1}))), 2);
  // Each corner in turn is missing from the top left window of nine pixels.
  for (int missing : {0, 1, 3}) {
    std::vector<float> depth(9, 1.0f);
    depth[missing] = kNan;
    const TriangleMesh mesh = TessellateView(Grid(3, depth));
    EXPECT_EQ(CountSeen(mesh), missing == 0 ? 7 : 6);
    ExpectClosedOutward(mesh);
  }
}

TEST(TessellateView, APlateHasItsBottomAsFarBelowAsPsiSays) {
  std::vector<float> depth;
  for (int r = 0; r < 6; ++r) {
    for (int c = 0; c < 8; ++c) depth.push_back(static_cast<float>(20.0 + 2.0 * c));  // z from 20 to 34 in steps of 2
  }
  for (double psi : {0.1, 0.2, 0.5, 1.0}) {
    const TriangleMesh mesh = TessellateView(Grid(8, depth), {.psi = psi});
    ExpectClosedOutward(mesh);
    double lowest = 0.0;
    for (const Eigen::Vector3d& v : mesh.vertices) lowest = std::max(lowest, v.z());
    EXPECT_NEAR(lowest, 34.0 + psi * 14.0, 1e-9);
    // Area 7 x 5 of mean depth 7 + psi 14 over the bottom.
    EXPECT_NEAR(Volume(mesh), 35.0 * (7.0 + 14.0 * psi), 1e-6);
    EXPECT_EQ(CountSeen(mesh), 70);
    for (int t = 0; t < 70; ++t) {
      EXPECT_EQ(mesh.triangle_seen[t], 1);
      EXPECT_LT(TriangleAreaVector(mesh, t).z(), 0.0);  // towards the sensor
    }
  }
}

TEST(TessellateView, ADepthJumpIsNotSpanned) {
  const TriangleMesh mesh = TessellateView(Grid(6, {1, 1, 1, 50, 50, 50, 1, 1, 1, 50, 50, 50, 1, 1, 1, 50, 50, 50}));
  EXPECT_EQ(Topology(mesh).components, 2);
  EXPECT_EQ(CountSeen(mesh), 16);
  ExpectClosedOutward(mesh);
  EXPECT_EQ(CountSeen(TessellateView(Grid(6, {1, 1, 1, 50, 50, 50, 1, 1, 1, 50, 50, 50, 1, 1, 1, 50, 50, 50}), {.max_depth_jump = 60})), 20);
}

TEST(TessellateView, WhatHangsOnByACornerIsTakenAway) {
  const TriangleMesh mesh = TessellateView(Grid(5, {1, 1, 1, kNan, kNan,  //
                                                    1, 1, 1, kNan, kNan,  //
                                                    1, 1, 1, 1, 1,        //
                                                    kNan, kNan, 1, 1, 1,  //
                                                    kNan, kNan, 1, 1, 1}));
  ExpectClosedOutward(mesh);
}

TEST(TessellateView, AHoleThroughStaysAndADropOutIsFilled) {
  std::vector<float> depth(49, 1.0f);
  depth[24] = kNan;
  RangeView view = Grid(7, depth);
  ExpectClosedOutward(TessellateView(view), 1);
  view.classes[24] = PixelClass::kNothing;
  ExpectClosedOutward(TessellateView(view), 0);
}

TEST(TessellateView, ASphereSeenInPerspectiveIsClosedAndLiesOnIt) {
  const Eigen::Vector3d center(0, 0, 0.05);
  const RangeView view = MakeView(SphereObject(center, 0.05), LookingAt(center, 0.45, 0.4, 0.3), 60, 0.26);
  for (int step : {1, 2, 3}) {
    const TriangleMesh mesh = TessellateView(view, {.step = step});
    ExpectClosedOutward(mesh);
    EXPECT_EQ(Topology(mesh).components, 1);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      if (!mesh.triangle_seen[t]) continue;
      for (int v : mesh.triangles[t]) EXPECT_NEAR((mesh.vertices[v] - Eigen::Vector3d(0, 0, 0.45)).norm(), 0.05, 1e-6);
    }
  }
}

TEST(TessellateView, RefusesAViewOfNothing) {
  EXPECT_THROW(TessellateView(Grid(2, {kNan, kNan, kNan, kNan})), std::invalid_argument);
  EXPECT_THROW(TessellateView(Grid(2, {1, 1, 1, 1}), {.step = 0}), std::invalid_argument);
}

}  // namespace
}  // namespace geond
