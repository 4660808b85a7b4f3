// SPDX-License-Identifier: Apache-2.0
#include "core/geometry/triangle_mesh.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include <gtest/gtest.h>

namespace geond {
namespace {

constexpr double kPi = std::numbers::pi;

TriangleMesh Tetrahedron() {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
  return mesh;
}

TriangleMesh Cube() {
  TriangleMesh mesh;
  for (int i = 0; i < 8; ++i) mesh.vertices.push_back({i & 1 ? 1.0 : 0.0, i & 2 ? 1.0 : 0.0, i & 4 ? 1.0 : 0.0});
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return mesh;
}

TriangleMesh Torus(int around, int across, double large, double small) {
  TriangleMesh mesh;
  for (int i = 0; i < around; ++i) {
    for (int j = 0; j < across; ++j) {
      const double u = 2 * kPi * i / around, v = 2 * kPi * j / across, r = large + small * std::cos(v);
      mesh.vertices.push_back({r * std::cos(u), r * std::sin(u), small * std::sin(v)});
      const int a = i * across + j, b = (i + 1) % around * across + j;
      const int c = i * across + (j + 1) % across, d = (i + 1) % around * across + (j + 1) % across;
      mesh.triangles.push_back({a, b, d});
      mesh.triangles.push_back({a, d, c});
    }
  }
  return mesh;
}

TriangleMesh Joined(TriangleMesh a, const TriangleMesh& b) {
  const int n = static_cast<int>(a.vertices.size());
  a.vertices.insert(a.vertices.end(), b.vertices.begin(), b.vertices.end());
  for (const auto& t : b.triangles) a.triangles.push_back({t[0] + n, t[1] + n, t[2] + n});
  return a;
}

TEST(Topology, Tetrahedron) {
  const MeshTopology topology = Topology(Tetrahedron());
  EXPECT_TRUE(topology.closed);
  EXPECT_TRUE(topology.manifold);
  EXPECT_EQ(topology.components, 1);
  EXPECT_EQ(topology.boundary_edges, 0);
  EXPECT_EQ(topology.genus, 0);
}

TEST(Topology, TorusHasGenusOneAndTwoOfThemTwo) {
  const TriangleMesh torus = Torus(12, 8, 1.0, 0.3);
  EXPECT_EQ(Topology(torus).genus, 1);
  const MeshTopology two = Topology(Joined(torus, Transform(Pose::Translation({5, 0, 0}), torus)));
  EXPECT_TRUE(two.closed && two.manifold);
  EXPECT_EQ(two.components, 2);
  EXPECT_EQ(two.genus, 2);
}

TEST(Topology, TwoShellsAreTwoComponents) {
  const MeshTopology topology = Topology(Joined(Cube(), Transform(Pose::Translation({3, 0, 0}), Tetrahedron())));
  EXPECT_TRUE(topology.closed && topology.manifold);
  EXPECT_EQ(topology.components, 2);
  EXPECT_EQ(topology.genus, 0);
}

TEST(Topology, AnOpenMeshHasABorder) {
  TriangleMesh mesh = Tetrahedron();
  mesh.triangles.pop_back();
  const MeshTopology topology = Topology(mesh);
  EXPECT_FALSE(topology.closed);
  EXPECT_TRUE(topology.manifold);
  EXPECT_EQ(topology.boundary_edges, 3);
}

TEST(Topology, ThreeTrianglesOnAnEdgeAreNoManifold) {
  // Two tetrahedra that share an edge.
  TriangleMesh mesh = Tetrahedron();
  mesh.vertices.push_back({0, -1, 0});
  mesh.vertices.push_back({0, 0, -1});
  for (const auto& t : std::vector<TriangleMesh::Triangle>{{0, 4, 1}, {0, 1, 5}, {1, 4, 5}, {4, 0, 5}})
    mesh.triangles.push_back(t);
  const MeshTopology topology = Topology(mesh);
  EXPECT_TRUE(topology.closed);
  EXPECT_FALSE(topology.manifold);
  EXPECT_EQ(topology.components, 1);
}

TEST(Topology, ABowTieIsNoManifold) {
  // Two tetrahedra that share one vertex and no edge.
  TriangleMesh mesh = Tetrahedron();
  mesh.vertices.insert(mesh.vertices.end(), {{-1, 0, 0}, {0, -1, 0}, {0, 0, -1}});
  for (const auto& t : std::vector<TriangleMesh::Triangle>{{0, 5, 4}, {0, 4, 6}, {4, 5, 6}, {5, 0, 6}})
    mesh.triangles.push_back(t);
  const MeshTopology topology = Topology(mesh);
  EXPECT_TRUE(topology.closed);
  EXPECT_FALSE(topology.manifold);
  EXPECT_EQ(topology.components, 2);
}

TEST(Topology, ATriangleTurnedOverIsNoManifold) {
  TriangleMesh mesh = Cube();
  std::swap(mesh.triangles[3][0], mesh.triangles[3][1]);
  EXPECT_TRUE(Topology(mesh).closed);
  EXPECT_FALSE(Topology(mesh).manifold);
}

TEST(Topology, NothingIsNeitherClosedNorManifold) {
  const MeshTopology topology = Topology({});
  EXPECT_FALSE(topology.closed);
  EXPECT_FALSE(topology.manifold);
  EXPECT_EQ(topology.components, 0);
}

TEST(TriangleNeighbors, AreMutualAndShareTheEdge) {
  for (const TriangleMesh& mesh : {Tetrahedron(), Cube(), Torus(9, 7, 1.0, 0.4)}) {
    const auto neighbors = TriangleNeighbors(mesh);
    for (int t = 0; t < static_cast<int>(mesh.triangles.size()); ++t) {
      for (int side = 0; side < 3; ++side) {
        const int other = neighbors[t][side];
        ASSERT_GE(other, 0);
        EXPECT_NE(std::find(neighbors[other].begin(), neighbors[other].end(), t), neighbors[other].end());
        for (int v : {mesh.triangles[t][side], mesh.triangles[t][(side + 1) % 3]}) {
          EXPECT_NE(std::find(mesh.triangles[other].begin(), mesh.triangles[other].end(), v),
                    mesh.triangles[other].end());
        }
      }
    }
  }
}

TEST(TriangleNeighbors, EndAtABorderAndGoRoundAnEdgeOfThree) {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}};
  mesh.triangles = {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}};
  const auto neighbors = TriangleNeighbors(mesh);
  EXPECT_EQ(neighbors[0], (std::array<int, 3>{1, -1, -1}));
  EXPECT_EQ(neighbors[1], (std::array<int, 3>{2, -1, -1}));
  EXPECT_EQ(neighbors[2], (std::array<int, 3>{0, -1, -1}));
}

TEST(Measures, OfCubeAndTetrahedron) {
  EXPECT_DOUBLE_EQ(Area(Cube()), 6.0);
  EXPECT_DOUBLE_EQ(Volume(Cube()), 1.0);
  EXPECT_NEAR(MinAngle(Cube()), kPi / 4, 1e-15);
  EXPECT_NEAR(MeanEdgeLength(Cube()), (2.0 + std::sqrt(2.0)) / 3.0, 1e-15);
  EXPECT_DOUBLE_EQ(Volume(Tetrahedron()), 1.0 / 6.0);
  EXPECT_DOUBLE_EQ(Area(Tetrahedron()), 1.5 + std::sqrt(3.0) / 2.0);
}

TEST(Measures, OfATorusConvergeToPappus) {
  const TriangleMesh torus = Torus(200, 100, 1.0, 0.3);
  EXPECT_NEAR(Volume(torus), 2 * kPi * kPi * 0.09, 2e-3 * 2 * kPi * kPi * 0.09);
  EXPECT_NEAR(Area(torus), 4 * kPi * kPi * 0.3, 1e-3 * 4 * kPi * kPi * 0.3);
}

TEST(Measures, ScaleAndMoveAsTheyShould) {
  const TriangleMesh torus = Torus(20, 10, 1.0, 0.3);
  const Pose pose = Pose::Translation({100, 50, -30}) * Pose::Rotation({1, 1, 0}, 2.0);
  const TriangleMesh moved = Transform(pose, torus);
  EXPECT_NEAR(Volume(moved), Volume(torus), 1e-12);
  EXPECT_NEAR(Area(moved), Area(torus), 1e-12);
  TriangleMesh tiny = torus;
  for (auto& v : tiny.vertices) v *= 1e-6;
  EXPECT_NEAR(Volume(tiny) / Volume(torus), 1e-18, 1e-30);
  EXPECT_NEAR(MinAngle(tiny), MinAngle(torus), 1e-9);
  EXPECT_EQ(Topology(tiny).genus, 1);
  TriangleMesh inside_out = torus;
  for (auto& t : inside_out.triangles) std::swap(t[0], t[1]);
  EXPECT_DOUBLE_EQ(Volume(inside_out), -Volume(torus));
}

TEST(Normals, PointOutwardAndSumToNothing) {
  const TriangleMesh torus = Torus(30, 20, 1.0, 0.3);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  const std::vector<Eigen::Vector3d> normals = TriangleNormals(torus), at_vertices = VertexNormals(torus);
  const std::vector<double> areas = TriangleAreas(torus);
  for (std::size_t t = 0; t < normals.size(); ++t) {
    sum += areas[t] * normals[t];
    const Eigen::Vector3d centroid = TriangleCentroid(torus, static_cast<int>(t));
    const Eigen::Vector3d ring = Eigen::Vector3d(centroid.x(), centroid.y(), 0).normalized();
    EXPECT_GT(normals[t].dot(centroid - ring), 0.0);
  }
  EXPECT_LT(sum.norm(), 1e-13);
  for (std::size_t v = 0; v < at_vertices.size(); ++v) {
    const Eigen::Vector3d& p = torus.vertices[v];
    const Eigen::Vector3d exact = (p - Eigen::Vector3d(p.x(), p.y(), 0).normalized()).normalized();
    EXPECT_GT(at_vertices[v].dot(exact), 0.995);
  }
}

TEST(Normals, OfATriangleWithoutAreaAreZero) {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 1, 1}, {2, 2, 2}};
  mesh.triangles = {{0, 1, 2}};
  EXPECT_EQ(TriangleNormals(mesh)[0], Eigen::Vector3d(0, 0, 0));
  EXPECT_EQ(TriangleAreas(mesh)[0], 0.0);
  EXPECT_EQ(MinAngle(mesh), 0.0);
}

TEST(CheckMesh, NamesTheTriangle) {
  TriangleMesh mesh = Cube();
  EXPECT_NO_THROW(CheckMesh(mesh));
  for (int bad : {-1, 8}) {
    mesh = Cube();
    mesh.triangles[5][1] = bad;
    try {
      CheckMesh(mesh);
      FAIL();
    } catch (const std::invalid_argument& error) {
      EXPECT_NE(std::string(error.what()).find("triangle 5"), std::string::npos);
    }
  }
  mesh = Cube();
  mesh.vertices[3].y() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(CheckMesh(mesh), std::invalid_argument);
}

}  // namespace
}  // namespace geond
