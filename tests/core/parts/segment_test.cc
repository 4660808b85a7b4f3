// SPDX-License-Identifier: Apache-2.0
#include "core/parts/segment.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <random>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "core/base/error.h"
#include "tests/core/parts/segmentation_case.h"

namespace geond {
namespace {

using test::RandIndex;
using test::SegmentationCase;

SegmentationCase Case(const std::string& name) {
  return test::ReadSegmentationCase(GEOND_TEST_DATA "/segmentation", name);
}

// The laws every segmentation keeps: each triangle in a part, parts in one piece and by falling area, boundaries that
// are the borders of the labels.
void ExpectLawful(const TriangleMesh& mesh, const PartSegmentation& parts) {
  ASSERT_EQ(parts.labels.size(), mesh.triangles.size());
  ASSERT_EQ(parts.significance.size(), static_cast<std::size_t>(parts.n_parts));
  const std::vector<double> areas = TriangleAreas(mesh);
  std::vector<double> area_of(parts.n_parts, 0.0);
  for (std::size_t t = 0; t < areas.size(); ++t) {
    ASSERT_GE(parts.labels[t], 0);
    ASSERT_LT(parts.labels[t], parts.n_parts);
    area_of[parts.labels[t]] += areas[t];
  }
  for (int p = 1; p < parts.n_parts; ++p) EXPECT_GE(area_of[p - 1], area_of[p] * (1.0 - 1e-9));
  const auto neighbors = TriangleNeighbors(mesh);
  std::vector<bool> seen(mesh.triangles.size(), false);
  int pieces = 0;
  std::map<std::pair<int, int>, double> lengths;
  for (std::size_t start = 0; start < seen.size(); ++start) {
    for (int side = 0; side < 3; ++side) {
      const int next = neighbors[start][side];
      if (next < 0 || parts.labels[next] <= parts.labels[start]) continue;
      const auto& t = mesh.triangles[start];
      lengths[{parts.labels[start], parts.labels[next]}] +=
          (mesh.vertices[t[side]] - mesh.vertices[t[(side + 1) % 3]]).norm();
    }
    if (seen[start]) continue;
    ++pieces;
    std::vector<int> queue = {static_cast<int>(start)};
    seen[start] = true;
    for (std::size_t i = 0; i < queue.size(); ++i) {
      for (int next : neighbors[queue[i]]) {
        if (next < 0 || seen[next] || parts.labels[next] != parts.labels[start]) continue;
        seen[next] = true;
        queue.push_back(next);
      }
    }
  }
  EXPECT_EQ(pieces, parts.n_parts);
  ASSERT_EQ(parts.boundaries.size(), lengths.size());
  for (const PartBoundary& b : parts.boundaries) {
    EXPECT_LT(b.a, b.b);
    ASSERT_TRUE(lengths.contains({b.a, b.b}));
    EXPECT_NEAR(b.length / lengths[std::pair(b.a, b.b)], 1.0, 0.25);  // smoothing of rough meshes shortens it
    EXPECT_LE(std::abs(b.strength), 1.0);
  }
  for (double s : parts.significance) {
    EXPECT_GE(s, 0.0);
    EXPECT_LE(s, 1.0);
  }
}

// The same surface, triangles and vertices numbered anew, and which triangle became which.
TriangleMesh Renumbered(const TriangleMesh& mesh, std::vector<int>& triangle_from) {
  std::mt19937_64 random(7);
  const auto shuffle = [&](int n) {
    std::vector<int> order(n);
    std::iota(order.begin(), order.end(), 0);
    for (int i = n - 1; i > 0; --i) std::swap(order[i], order[random() % (i + 1)]);
    return order;
  };
  const std::vector<int> vertex_from = shuffle(static_cast<int>(mesh.vertices.size()));
  triangle_from = shuffle(static_cast<int>(mesh.triangles.size()));
  std::vector<int> vertex_to(vertex_from.size());
  TriangleMesh result;
  for (std::size_t i = 0; i < vertex_from.size(); ++i) {
    vertex_to[vertex_from[i]] = static_cast<int>(i);
    result.vertices.push_back(mesh.vertices[vertex_from[i]]);
  }
  for (int t : triangle_from) {
    const auto& [a, b, c] = mesh.triangles[t];
    result.triangles.push_back({vertex_to[b], vertex_to[c], vertex_to[a]});
  }
  return result;
}

class SegmentPartsOfCase : public testing::TestWithParam<const char*> {};

TEST_P(SegmentPartsOfCase, FindsTheTruePartsLawfully) {
  const SegmentationCase c = Case(GetParam());
  const PartSegmentation parts = SegmentParts(c.mesh, c.charge);
  ExpectLawful(c.mesh, parts);
  EXPECT_EQ(parts.n_parts, c.n_parts);
  EXPECT_GT(RandIndex(parts.labels, c.labels), 0.95);
  EXPECT_FALSE(parts.message.empty());
}

INSTANTIATE_TEST_SUITE_P(Cases, SegmentPartsOfCase,
                         testing::Values("clean1500_pin", "clean1500_peanut", "clean1500_animal", "clean1500_banana",
                                         "clean1500_plate", "clean1500_ellipsoid", "clean1500_mug", "noise0.5_snowman",
                                         "noise0.5_cuboid", "uneven_boxcyl"),
                         [](const auto& value) {
                           std::string name = value.param;
                           std::replace_if(
                               name.begin(), name.end(), [](char c) { return !std::isalnum(c); }, '_');
                           return name;
                         });

TEST(SegmentParts, DoesNotDependOnTheNumbering) {
  const SegmentationCase c = Case("clean1500_animal");
  for (auto method :
       {SegmentOptions::Method::kWatershed, SegmentOptions::Method::kTrace, SegmentOptions::Method::kThreshold}) {
    SegmentOptions options;
    options.method = method;
    const PartSegmentation parts = SegmentParts(c.mesh, c.charge, options);
    ExpectLawful(c.mesh, parts);
    std::vector<int> from;
    const TriangleMesh renumbered = Renumbered(c.mesh, from);
    ChargeDensity charge;
    for (int t : from) charge.density.push_back(c.charge.density[t]);
    const PartSegmentation again = SegmentParts(renumbered, charge, options);
    ASSERT_EQ(again.n_parts, parts.n_parts);
    for (std::size_t i = 0; i < from.size(); ++i) ASSERT_EQ(again.labels[i], parts.labels[from[i]]);
    for (int p = 0; p < parts.n_parts; ++p) EXPECT_DOUBLE_EQ(again.significance[p], parts.significance[p]);
  }
}

TEST(SegmentParts, TurnsAndScalesWithTheObject) {
  const SegmentationCase c = Case("clean1500_pin");
  const PartSegmentation parts = SegmentParts(c.mesh, c.charge);
  TriangleMesh moved = c.mesh;
  const Eigen::Matrix3d R = Eigen::AngleAxisd(1.1, Eigen::Vector3d(1, -2, 0.5).normalized()).toRotationMatrix();
  for (auto& v : moved.vertices) v = 0.001 * (R * v) + Eigen::Vector3d(0.3, -0.2, 0.1);
  ChargeDensity charge = c.charge;
  for (double& d : charge.density) d *= 1e6;
  const PartSegmentation again = SegmentParts(moved, charge);
  EXPECT_EQ(again.n_parts, parts.n_parts);
  EXPECT_GT(RandIndex(again.labels, parts.labels), 0.998);
  ASSERT_EQ(again.boundaries.size(), 1u);
  EXPECT_NEAR(again.boundaries[0].length, 0.001 * parts.boundaries[0].length, 1e-6 * parts.boundaries[0].length);
}

TEST(SegmentParts, TellsOfTheCutAroundAPeanut) {
  const SegmentationCase c = Case("clean1500_peanut");
  const PartSegmentation parts = SegmentParts(c.mesh, c.charge);
  ASSERT_EQ(parts.boundaries.size(), 1u);
  EXPECT_TRUE(parts.boundaries[0].closed);
  EXPECT_GT(parts.boundaries[0].strength, 0.2);
  EXPECT_GT(parts.boundaries[0].contrast, 0.3);
  for (double s : parts.significance) EXPECT_GT(s, 0.5);
}

TEST(SegmentParts, CutsAnOpenMeshUpToItsBorder) {
  const SegmentationCase c = Case("clean1500_peanut");
  TriangleMesh half;  // one side of the peanut, as one view sees it
  half.vertices = c.mesh.vertices;
  ChargeDensity charge;
  std::vector<int> labels;
  Eigen::Vector3d view = Eigen::Vector3d::Zero();  // across the line from one part's middle to the other's
  Eigen::Vector3d middle[2] = {Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
  for (std::size_t t = 0; t < c.labels.size(); ++t)
    middle[c.labels[t]] += TriangleCentroid(c.mesh, static_cast<int>(t));
  view = (middle[1] / std::count(c.labels.begin(), c.labels.end(), 1) -
          middle[0] / std::count(c.labels.begin(), c.labels.end(), 0))
             .unitOrthogonal();
  for (std::size_t t = 0; t < c.labels.size(); ++t) {
    if (TriangleAreaVector(c.mesh, static_cast<int>(t)).stableNormalized().dot(view) < 0.1) continue;
    half.triangles.push_back(c.mesh.triangles[t]);
    charge.density.push_back(c.charge.density[t]);
    labels.push_back(c.labels[t]);
  }
  const PartSegmentation parts = SegmentParts(half, charge);
  EXPECT_LE(std::count(parts.labels.begin(), parts.labels.end(), -1), 5);  // specks that the cutting left
  EXPECT_EQ(parts.n_parts, 2);
  EXPECT_GT(RandIndex(parts.labels, labels), 0.97);
  ASSERT_EQ(parts.boundaries.size(), 1u);
  EXPECT_FALSE(parts.boundaries[0].closed);
}

TEST(SegmentParts, ThresholdFindsTheTwoEndsOfAPeanut) {
  const SegmentationCase c = Case("clean1500_peanut");
  SegmentOptions options;
  options.method = SegmentOptions::Method::kThreshold;
  const PartSegmentation parts = SegmentParts(c.mesh, c.charge, options);
  EXPECT_EQ(parts.n_parts, 2);
  EXPECT_GT(RandIndex(parts.labels, c.labels), 0.97);
}

TEST(SegmentParts, DetailRunsFromCoarseToFine) {
  const SegmentationCase c = Case("clean1500_animal");
  std::vector<PartSegmentation> by_detail;
  for (double detail : {0.0, 0.25, 0.5, 1.0}) {
    SegmentOptions options;
    options.detail = detail;
    by_detail.push_back(SegmentParts(c.mesh, c.charge, options));
    ExpectLawful(c.mesh, by_detail.back());
  }
  for (std::size_t i = 1; i < by_detail.size(); ++i) EXPECT_LE(by_detail[i - 1].n_parts, by_detail[i].n_parts);
  EXPECT_LT(by_detail[0].n_parts, by_detail[2].n_parts);
  // What is coarse is made of what is less coarse: no part of the default lies in two coarse ones.
  for (int i : {0, 1}) {
    std::map<int, std::set<int>> coarse_of;
    for (std::size_t t = 0; t < c.labels.size(); ++t) coarse_of[by_detail[2].labels[t]].insert(by_detail[i].labels[t]);
    for (const auto& [part, coarse] : coarse_of) EXPECT_EQ(coarse.size(), 1u);
  }
}

TEST(SegmentParts, ThrowsOnCallersMistakes) {
  const SegmentationCase c = Case("clean1500_peanut");
  ChargeDensity charge = c.charge;
  charge.density.pop_back();
  EXPECT_THROW(SegmentParts(c.mesh, charge), std::invalid_argument);
  SegmentOptions options;
  options.detail = 1.5;
  EXPECT_THROW(SegmentParts(c.mesh, c.charge, options), std::invalid_argument);
  options = {};
  options.noise = -1.0;
  EXPECT_THROW(SegmentParts(c.mesh, c.charge, options), std::invalid_argument);
  charge = c.charge;
  charge.density[5] = std::nan("");
  EXPECT_THROW(SegmentParts(c.mesh, charge), std::invalid_argument);
  std::stop_source source;
  source.request_stop();
  EXPECT_THROW(SegmentParts(c.mesh, c.charge, {}, source.get_token()), Cancelled);
}

TEST(SegmentParts, TakesMeshesWithoutTrianglesOrArea) {
  EXPECT_EQ(SegmentParts({}, {}).n_parts, 0);
  TriangleMesh flat;
  flat.vertices = {{0, 0, 0}, {0, 0, 0}, {0, 0, 0}};
  flat.triangles = {{0, 1, 2}};
  ChargeDensity charge;
  charge.density = {1.0};
  EXPECT_EQ(SegmentParts(flat, charge).n_parts, 1);
}

}  // namespace
}  // namespace geond
