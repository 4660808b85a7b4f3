// SPDX-License-Identifier: Apache-2.0
#include "core/surface/remesh.h"

#include <cmath>
#include <numbers>
#include <stdexcept>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/surface/half_edge_mesh.h"
#include "core/surface/triangle_tree.h"
#include "tests/core/surface/shapes.h"

namespace geond {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

void ExpectClosed(const TriangleMesh& mesh, int genus, int components = 1) {
  const MeshTopology topology = Topology(mesh);
  EXPECT_TRUE(topology.closed);
  EXPECT_TRUE(topology.manifold);
  EXPECT_EQ(topology.genus, genus);
  EXPECT_EQ(topology.components, components);
}

TEST(TriangleTree, FindsWhatTryingAllFinds) {
  const TriangleMesh torus = Torus(1.0, 0.4, 20, 12);
  const TriangleTree tree(torus.vertices, torus.triangles);
  for (int i = 0; i < 200; ++i) {
    const Eigen::Vector3d p(std::sin(1.0 + i), std::sin(2.0 + 3 * i), 0.6 * std::sin(5.0 * i));
    double best = 1e300;
    for (const auto& [a, b, c] : torus.triangles) {
      best = std::min(best, (NearestOnTriangle(p, torus.vertices[a], torus.vertices[b], torus.vertices[c]) - p).squaredNorm());
    }
    const TriangleTree::Hit hit = tree.Nearest(p);
    EXPECT_DOUBLE_EQ(hit.squared_distance, best);
    EXPECT_NEAR((hit.point - p).squaredNorm(), best, 1e-15);
    EXPECT_EQ(tree.Nearest(p, 0.9 * std::sqrt(best)).triangle, -1);
  }
  EXPECT_EQ(TriangleTree().Nearest({0, 0, 0}).triangle, -1);
}

TEST(HalfEdgeMesh, EveryOperationKeepsTheMeshAClosedManifoldOfItsGenus) {
  HalfEdgeMesh mesh(Torus(1.0, 0.4, 10, 8));
  int flips = 0, collapses = 0;
  for (int round = 0; round < 400; ++round) {
    const int h = static_cast<int>((round * 7919LL) % mesh.n_half_edges());
    if (!mesh.alive(h)) continue;
    if (round % 3 == 0) {
      mesh.Split(h, 0.5 * (mesh.points[mesh.origin[h]] + mesh.points[mesh.target(h)]));
    } else if (round % 3 == 1 && mesh.CanFlip(h)) {
      mesh.Flip(h);
      ++flips;
    } else if (mesh.CanCollapse(h)) {
      mesh.Collapse(h);
      ++collapses;
    }
    if (round % 40 == 39) ExpectClosed(mesh.ToMesh(), 1);
  }
  EXPECT_GT(flips, 50);
  EXPECT_GT(collapses, 50);
}

TEST(HalfEdgeMesh, ATetrahedronDoesNotCollapse) {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
  const HalfEdgeMesh tetrahedron(mesh);
  for (int h = 0; h < 12; ++h) {
    EXPECT_FALSE(tetrahedron.CanCollapse(h));
    EXPECT_FALSE(tetrahedron.CanFlip(h));
  }
}

TEST(Remesh, ASphereStaysASphereAtAnyLength) {
  const TriangleMesh sphere = Sphere(0.05, 4);
  for (double edge : {0.004, 0.008, 0.016}) {
    const TriangleMesh mesh = Remesh(sphere, {.edge_length = edge});
    ExpectClosed(mesh, 0);
    EXPECT_NEAR(MeanEdgeLength(mesh), edge, 0.12 * edge);
    EXPECT_GT(MinAngle(mesh), 30 * kDegree);
    for (const Eigen::Vector3d& v : mesh.vertices) EXPECT_NEAR(v.norm(), 0.05, 2e-4);
  }
}

TEST(Remesh, GivesAboutTheWantedNumberOfTriangles) {
  const TriangleMesh torus = Torus(0.05, 0.02, 60, 24);
  for (int wanted : {500, 2000, 8000}) {
    const TriangleMesh mesh = Remesh(torus, {.triangles = wanted});
    ExpectClosed(mesh, 1);
    EXPECT_NEAR(static_cast<double>(mesh.triangles.size()), wanted, 0.1 * wanted);
    EXPECT_NEAR(Volume(mesh) / Volume(torus), 1.0, 40.0 / wanted);  // chords lie inside: the loss goes with the area
  }
}

TEST(Remesh, KeepsCreasesAndCorners) {
  const TriangleMesh mesh = Remesh(Cube(0.05), {.edge_length = 0.01});
  ExpectClosed(mesh, 0);
  EXPECT_NEAR(Volume(mesh), 1e-3, 1e-9);
  EXPECT_NEAR(Area(mesh), 0.06, 1e-7);
  EXPECT_GT(MinAngle(mesh), 28 * kDegree);
}

TEST(Remesh, KeepsComponentsAndWhatWasSeen) {
  TriangleMesh two = Sphere(0.03, 3);
  const TriangleMesh other = Torus(0.05, 0.02, 30, 16);
  const int offset = static_cast<int>(two.vertices.size());
  two.triangle_seen.assign(two.triangles.size(), 1);
  for (const Eigen::Vector3d& v : other.vertices) two.vertices.push_back(v + Eigen::Vector3d(0.2, 0, 0));
  for (const auto& [a, b, c] : other.triangles) two.triangles.push_back({a + offset, b + offset, c + offset});
  two.triangle_seen.resize(two.triangles.size(), 0);
  const TriangleMesh mesh = Remesh(two, {.triangles = 2500});
  ExpectClosed(mesh, 1, 2);
  ASSERT_EQ(mesh.triangle_seen.size(), mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    EXPECT_EQ(mesh.triangle_seen[t], TriangleCentroid(mesh, static_cast<int>(t)).x() < 0.1);
  }
}

TEST(Remesh, ScalesWithTheInput) {
  TriangleMesh torus = Torus(0.05, 0.02, 40, 20);
  const TriangleMesh one = Remesh(torus, {.edge_length = 0.005});
  for (Eigen::Vector3d& v : torus.vertices) v *= 4.0;
  const TriangleMesh other = Remesh(torus, {.edge_length = 0.02});
  ASSERT_EQ(one.triangles, other.triangles);
  for (std::size_t v = 0; v < one.vertices.size(); ++v) EXPECT_LT((4.0 * one.vertices[v] - other.vertices[v]).norm(), 1e-12);
}

TEST(Remesh, IsTheSameForAnyNumberOfThreads) {
  const TriangleMesh torus = Torus(0.05, 0.02, 40, 20);
  const TriangleMesh one = Remesh(torus, {.triangles = 3000, .threads = 1});
  const TriangleMesh four = Remesh(torus, {.triangles = 3000, .threads = 4});
  EXPECT_EQ(one.triangles, four.triangles);
  EXPECT_EQ(one.vertices, four.vertices);
}

TEST(Remesh, RefusesWhatItCannotDo) {
  TriangleMesh open = Cube(1.0);
  open.triangles.pop_back();
  EXPECT_THROW(Remesh(open, {.edge_length = 0.1}), std::invalid_argument);
  EXPECT_THROW(Remesh(Cube(1.0), {}), std::invalid_argument);
  std::stop_source stop;
  stop.request_stop();
  EXPECT_THROW(Remesh(Cube(1.0), {.edge_length = 0.1}, stop.get_token()), Cancelled);
}

TEST(Remesh, IsTheSameInMetresAndInMillimetres) {
  // Even steps all round: full of ties between edges.
  const TriangleMesh torus = Torus(0.3, 0.1, 8, 6);
  TriangleMesh small = torus;
  for (Eigen::Vector3d& p : small.vertices) p *= 0.001;
  const TriangleMesh a = Remesh(torus, {.triangles = 600}), b = Remesh(small, {.triangles = 600});
  EXPECT_EQ(a.triangles, b.triangles);
  ASSERT_EQ(a.vertices.size(), b.vertices.size());
  for (std::size_t v = 0; v < a.vertices.size(); ++v) EXPECT_LT((0.001 * a.vertices[v] - b.vertices[v]).norm(), 1e-15);
}

}  // namespace
}  // namespace geond
