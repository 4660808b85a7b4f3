// SPDX-License-Identifier: Apache-2.0
#include "core/surface/close_mesh.h"

#include <cmath>
#include <stdexcept>

#include <gtest/gtest.h>

#include "core/surface/winding_number.h"
#include "tests/core/surface/shapes.h"

namespace geond {
namespace {

void ExpectSolid(const TriangleMesh& mesh, int genus, double volume, double tolerance) {
  const MeshTopology topology = Topology(mesh);
  EXPECT_TRUE(topology.closed);
  EXPECT_TRUE(topology.manifold);
  EXPECT_EQ(topology.components, 1);
  EXPECT_EQ(topology.genus, genus);
  EXPECT_NEAR(Volume(mesh) / volume, 1.0, tolerance);
  EXPECT_GT(MinAngle(mesh), 0.3);
}

TEST(WindingNumber, IsOneInsideAndZeroOutsideOfAClosedMesh) {
  const WindingNumber winding(Torus(1.0, 0.4, 60, 40));
  EXPECT_NEAR(winding.At({1.0, 0.05, 0.1}), 1.0, 0.02);
  EXPECT_NEAR(winding.At({0.0, 0.0, 0.0}), 0.0, 0.02);
  EXPECT_NEAR(winding.At({3.0, 1.0, 0.0}), 0.0, 0.02);
}

TEST(WindingNumber, IsHalfInTheMouthOfAHemisphere) {
  TriangleMesh hemisphere = Sphere(1.0, 5);
  std::erase_if(hemisphere.triangles, [&](const auto& t) {
    return hemisphere.vertices[t[0]].z() + hemisphere.vertices[t[1]].z() + hemisphere.vertices[t[2]].z() < 0;
  });
  EXPECT_NEAR(WindingNumber(hemisphere).At({0, 0, 0}), 0.5, 0.04);
}

TEST(WindingNumber, OfPointsIsThatOfTheirSurface) {
  const TriangleMesh sphere = Sphere(1.0, 4);
  std::vector<Eigen::Vector3d> points, areas;
  for (int t = 0; t < static_cast<int>(sphere.triangles.size()); ++t) {
    points.push_back(TriangleCentroid(sphere, t));
    areas.push_back(TriangleAreaVector(sphere, t));
  }
  const WindingNumber winding(points, areas);
  EXPECT_NEAR(winding.At({0.3, -0.5, 0.2}), 1.0, 0.05);
  EXPECT_NEAR(winding.At({0.9, -0.9, 0.2}), 0.0, 0.05);
}

TEST(CloseMesh, AClosedMeshStaysWhatItIs) {
  const TriangleMesh torus = Torus(0.05, 0.02, 60, 30);
  ExpectSolid(CloseMesh(torus), 1, Volume(torus), 0.02);
}

TEST(CloseMesh, HolesAreClosedOverAndMarked) {
  TriangleMesh sphere = Sphere(0.05, 4);
  std::erase_if(sphere.triangles, [&](const auto& t) { return sphere.vertices[t[0]].z() < -0.04; });
  const TriangleMesh closed = CloseMesh(sphere);
  ExpectSolid(closed, 0, 4.0 / 3.0 * std::numbers::pi * 1.25e-4, 0.04);
  ASSERT_EQ(closed.triangle_seen.size(), closed.triangles.size());
  for (std::size_t t = 0; t < closed.triangles.size(); ++t) {
    if (TriangleCentroid(closed, static_cast<int>(t)).z() > -0.03) {
      EXPECT_EQ(closed.triangle_seen[t], 1);
    }
  }
  EXPECT_LT(std::count(closed.triangle_seen.begin(), closed.triangle_seen.end(), 1), std::ssize(closed.triangles));
}

TEST(CloseMesh, UnweldedDoubledAndWronglyTurnedTrianglesAreMended) {
  const TriangleMesh sphere = Sphere(0.05, 3);
  TriangleMesh soup;
  for (std::size_t t = 0; t < sphere.triangles.size(); ++t) {
    for (int copy = 0; copy < (t % 7 == 0 ? 2 : 1); ++copy) {
      const int base = static_cast<int>(soup.vertices.size());
      for (int v : sphere.triangles[t]) soup.vertices.push_back(sphere.vertices[v]);
      if (t % 5 == 0) soup.triangles.push_back({base, base + 2, base + 1});
      else soup.triangles.push_back({base, base + 1, base + 2});
    }
  }
  ExpectSolid(CloseMesh(soup), 0, Volume(sphere), 0.03);
}

TEST(CloseMesh, SolidsThatRunIntoEachOtherBecomeOne) {
  TriangleMesh two = Sphere(0.03, 3);
  const TriangleMesh other = Sphere(0.03, 3);
  const int offset = static_cast<int>(two.vertices.size());
  for (const Eigen::Vector3d& v : other.vertices) two.vertices.push_back(v + Eigen::Vector3d(0.03, 0.001, 0.002));
  for (const auto& [a, b, c] : other.triangles) two.triangles.push_back({a + offset, b + offset, c + offset});
  const double r = 0.03, d = std::sqrt(0.03 * 0.03 + 5e-6);
  const double lens = std::numbers::pi * std::pow(2 * r - d, 2) * (d * d + 4 * d * r) / (12 * d);
  ExpectSolid(CloseMesh(two), 0, 8.0 / 3.0 * std::numbers::pi * r * r * r - lens, 0.03);
}

TEST(CloseMesh, RefusesWhatEnclosesNothing) {
  TriangleMesh sheet;
  sheet.vertices = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  sheet.triangles = {{0, 1, 2}, {0, 2, 3}};
  EXPECT_THROW(CloseMesh(sheet), std::invalid_argument);
}

}  // namespace
}  // namespace geond
