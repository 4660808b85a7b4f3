// SPDX-License-Identifier: Apache-2.0
#include "core/surface/tessellate.h"

#include <cmath>
#include <random>
#include <stdexcept>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/surface/integrate.h"
#include "tests/core/surface/shapes.h"
#include "tests/core/surface/views.h"

namespace geond {
namespace {

void ExpectSolid(const TriangleMesh& mesh, int genus) {
  const MeshTopology topology = Topology(mesh);
  EXPECT_TRUE(topology.closed);
  EXPECT_TRUE(topology.manifold);
  EXPECT_EQ(topology.components, 1);
  EXPECT_EQ(topology.genus, genus);
  EXPECT_EQ(mesh.triangle_seen.size(), mesh.triangles.size());
}

std::vector<RangeView> ViewsOf(const Object& object, double scale, int n = 6, bool table = true) {
  std::vector<RangeView> views;
  for (int i = 0; i < n; ++i) {
    const double angle = 2 * std::numbers::pi * i / n;
    views.push_back(MakeView(object, LookingAt(scale * Eigen::Vector3d(0, 0, 0.05), scale * 0.45, angle, 0.35), 72, 0.3, table));
  }
  return views;
}

double Rms(const TriangleMesh& mesh, const Eigen::Vector3d& center, double radius) {
  double sum = 0.0;
  int n = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (!mesh.triangle_seen[t]) continue;
    for (int v : mesh.triangles[t]) sum += std::pow((mesh.vertices[v] - center).norm() - radius, 2), ++n;
  }
  return std::sqrt(sum / n);
}

TEST(Tessellate, ASphereOnTheTableIsASphereWithAClosedBottom) {
  const Eigen::Vector3d center(0, 0, 0.05);
  const std::vector<RangeView> views = ViewsOf(SphereObject(center, 0.05), 1.0);
  const TriangleMesh mesh = Tessellate(views, IntegrateViews(views), {.triangles = 2000});
  ExpectSolid(mesh, 0);
  EXPECT_NEAR(static_cast<double>(mesh.triangles.size()), 2000.0, 200.0);
  EXPECT_LT(Rms(mesh, center, 0.05), 1e-4);
  EXPECT_NEAR(Volume(mesh) / (4.0 / 3.0 * std::numbers::pi * 1.25e-4), 1.0, 0.015);
  double lowest = 1.0;
  for (const Eigen::Vector3d& v : mesh.vertices) lowest = std::min(lowest, v.z());
  EXPECT_NEAR(lowest, 0.0, 2e-3);
  EXPECT_GT(MinAngle(mesh), 0.35);
}

TEST(Tessellate, ABoxKeepsItsEdgesAndItsFlatBottom) {
  const Eigen::Vector3d half(0.03, 0.02, 0.05);
  const std::vector<RangeView> views = ViewsOf(BoxObject(half), 1.0, 8);
  const TriangleMesh mesh = Tessellate(views, IntegrateViews(views), {.triangles = 3000});
  ExpectSolid(mesh, 0);
  EXPECT_NEAR(Volume(mesh), 0.06 * 0.04 * 0.05, 0.012 * 0.06 * 0.04 * 0.05);
  double bottom = 0.0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Eigen::Vector3d area = TriangleAreaVector(mesh, static_cast<int>(t));
    if (area.z() < -0.9 * area.norm()) {
      bottom -= area.z();
      EXPECT_LT(TriangleCentroid(mesh, static_cast<int>(t)).z(), 5e-4);
      // What no view saw is said to be closed over, but for the rim.
      const Eigen::Vector3d c = TriangleCentroid(mesh, static_cast<int>(t));
      if (std::abs(c.x()) < 0.02 && std::abs(c.y()) < 0.012) {
        EXPECT_EQ(mesh.triangle_seen[t], 0);
      }
    }
  }
  EXPECT_NEAR(bottom, 0.06 * 0.04, 0.05 * 0.06 * 0.04);
}

TEST(Tessellate, WithoutATableTheUnseenIsClosedAllTheSame) {
  const Eigen::Vector3d center(0, 0, 0.05);
  const std::vector<RangeView> views = ViewsOf(SphereObject(center, 0.05), 1.0, 6, false);
  const TriangleMesh mesh = Tessellate(views, IntegrateViews(views), {.triangles = 1500, .close_on_table = false});
  ExpectSolid(mesh, 0);
  EXPECT_LT(Rms(mesh, center, 0.05), 2e-4);
}

TEST(Tessellate, ScalesWithTheScene) {
  const std::vector<RangeView> one = ViewsOf(SphereObject({0, 0, 0.05}, 0.05), 1.0), ten = ViewsOf(SphereObject({0, 0, 0.5}, 0.5), 10.0);
  const TriangleMesh small = Tessellate(one, IntegrateViews(one), {.triangles = 800});
  const TriangleMesh large = Tessellate(ten, IntegrateViews(ten), {.triangles = 800});
  EXPECT_NEAR(Volume(large) / Volume(small), 1000.0, 5.0);
  EXPECT_NEAR(static_cast<double>(large.triangles.size()) / static_cast<double>(small.triangles.size()), 1.0, 0.03);
}

TEST(Tessellate, IsTheSameForAnyNumberOfThreads) {
  const std::vector<RangeView> views = ViewsOf(BoxObject({0.03, 0.02, 0.05}), 1.0, 4);
  const PointCloud merged = IntegrateViews(views);
  const TriangleMesh one = Tessellate(views, merged, {.triangles = 800, .threads = 1});
  const TriangleMesh four = Tessellate(views, merged, {.triangles = 800, .threads = 4});
  EXPECT_EQ(one.triangles, four.triangles);
  EXPECT_EQ(one.vertices, four.vertices);
  EXPECT_EQ(one.triangle_seen, four.triangle_seen);
}

TEST(Tessellate, RefusesNothingAndStopsWhenAsked) {
  EXPECT_THROW(Tessellate({}, {}), std::invalid_argument);
  const std::vector<RangeView> views = ViewsOf(SphereObject({0, 0, 0.05}, 0.05), 1.0, 2);
  std::stop_source stop;
  stop.request_stop();
  EXPECT_THROW(Tessellate(views, IntegrateViews(views), {}, stop.get_token()), Cancelled);
}

// Points on a mesh, spread by area, with noise (m) along the normal.
PointCloud PointsOn(const TriangleMesh& mesh, int n, double noise, bool normals) {
  std::mt19937_64 random(11);
  const auto uniform = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };
  std::vector<double> until;
  double total = 0.0;
  for (double a : TriangleAreas(mesh)) until.push_back(total += a);
  PointCloud cloud;
  for (int i = 0; i < n; ++i) {
    const int t = static_cast<int>(std::lower_bound(until.begin(), until.end(), uniform() * total) - until.begin());
    const double s = std::sqrt(uniform()), r = uniform();
    const auto& [a, b, c] = mesh.triangles[t];
    const Eigen::Vector3d normal = TriangleAreaVector(mesh, t).normalized();
    cloud.points.push_back((1 - s) * mesh.vertices[a] + s * (1 - r) * mesh.vertices[b] + s * r * mesh.vertices[c] +
                           noise * (uniform() + uniform() + uniform() - 1.5) * 2.0 * normal);
    if (normals) cloud.normals.push_back(normal);
  }
  return cloud;
}

TEST(TessellateCloud, ACloudWithNormalsOrWithoutIsClosed) {
  const TriangleMesh torus = Torus(0.05, 0.02, 80, 40);
  for (bool normals : {true, false}) {
    const TriangleMesh mesh = TessellateCloud(PointsOn(torus, 12000, 1e-4, normals), {.triangles = 2000});
    ExpectSolid(mesh, 1);
    EXPECT_NEAR(Volume(mesh) / Volume(torus), 1.0, 0.03);
    EXPECT_GT(MinAngle(mesh), 0.2);
  }
}

TEST(TessellateCloud, NormalsOfAnySignAreTurnedOutward) {
  PointCloud cloud = PointsOn(Cube(0.03), 8000, 5e-5, true);
  for (std::size_t i = 0; i < cloud.size(); i += 3) cloud.normals[i] = -cloud.normals[i];
  const TriangleMesh mesh = TessellateCloud(cloud, {.triangles = 1500});
  ExpectSolid(mesh, 0);
  EXPECT_NEAR(Volume(mesh) / 2.16e-4, 1.0, 0.04);
}

TEST(TessellateCloud, AnOpenBottomIsClosedOver) {
  TriangleMesh sphere = Sphere(0.05, 4);
  std::erase_if(sphere.triangles, [&](const auto& t) { return sphere.vertices[t[0]].z() < -0.035; });
  const TriangleMesh mesh = TessellateCloud(PointsOn(sphere, 9000, 5e-5, false), {.triangles = 1500});
  ExpectSolid(mesh, 0);
  EXPECT_GT(std::count(mesh.triangle_seen.begin(), mesh.triangle_seen.end(), 0), 20);
}

TEST(TessellateCloud, OneSideOfAnObjectIsRefusedInWords) {
  TriangleMesh sphere = Sphere(0.05, 4);
  std::erase_if(sphere.triangles, [&](const auto& t) { return sphere.vertices[t[0]].z() < 0.005; });
  try {
    TessellateCloud(PointsOn(sphere, 5000, 5e-5, false));
    FAIL() << "a hemisphere was closed";
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("from one side only"), std::string::npos);
  }
  EXPECT_THROW(TessellateCloud(PointsOn(sphere, 20, 0.0, false)), std::invalid_argument);
  EXPECT_THROW(TessellateCloud({}), std::invalid_argument);
}

}  // namespace
}  // namespace geond
