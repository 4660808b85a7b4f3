// SPDX-License-Identifier: Apache-2.0
#include "core/hollow_part.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "core/geometry/sample_mesh.h"
#include "core/object_model.h"
#include "tests/core/mesh_of_cubes.h"

namespace geond {
namespace {

// A box of 12 x 12 x 14 cubes and the same with walls of one cube and a floor of two: mm cubes.
TriangleMesh Box(bool hollow) {
  const auto solid = [&](int i, int j, int k) {
    return i < 12 && j < 12 && !(hollow && k >= 2 && i > 0 && i < 11 && j > 0 && j < 11);
  };
  TriangleMesh mesh = test::MeshOfCubes(14, solid);
  for (Eigen::Vector3d& v : mesh.vertices) v *= 1e-3;
  return mesh;
}

PartSegmentation OnePart(const TriangleMesh& mesh) {
  PartSegmentation one;
  one.n_parts = 1;
  one.labels.assign(mesh.triangles.size(), 0);
  return one;
}

TEST(OutsideOfPart, LeavesTheInnerWallsOfAVesselAndKeepsTheRest) {
  const TriangleMesh vessel = Box(true);
  const PointCloud all = SampleMesh(vessel, 4000), outside = OutsideOfPart(all, vessel, OnePart(vessel), 0);
  const auto in_hollow = [](const Eigen::Vector3d& p) {
    return p.z() > 2.1e-3 && p.z() < 13.9e-3 && p.x() > 0.5e-3 && p.x() < 11.5e-3 && p.y() > 0.5e-3 && p.y() < 11.5e-3;
  };
  EXPECT_EQ(std::count_if(outside.points.begin(), outside.points.end(), in_hollow), 0);
  const auto n_inner = std::count_if(all.points.begin(), all.points.end(), in_hollow);
  EXPECT_GT(n_inner, 1000);
  EXPECT_GT(outside.size(), 0.7 * static_cast<double>(all.size() - n_inner));  // some lie beside the rim
}

TEST(OutsideOfPart, ASolidHasNoHollow) {
  const TriangleMesh solid = Box(false);
  EXPECT_TRUE(OutsideOfPart(SampleMesh(solid, 1000), solid, OnePart(solid), 0).empty());
}

TEST(BuildObjectModel, AVesselIsOnePartOfTheShapeOfItsOutside) {
  const ObjectModel model = BuildObjectModel(Box(true), {});
  ASSERT_EQ(model.description.parts.size(), 1u);
  const Geon& geon = model.description.parts[0].fits.front().geon;
  EXPECT_EQ(geon.type, GeonType::kCuboid);
  const Eigen::Vector3d expected = {6e-3, 6e-3, 7e-3};
  EXPECT_LT((geon.size - expected).cwiseAbs().maxCoeff(), 0.2e-3) << geon.size.transpose();
  const std::vector<std::string>& notes = model.description.notes;
  EXPECT_TRUE(std::any_of(notes.begin(), notes.end(),
                          [](const std::string& note) { return note.find("part 1 is hollow") != std::string::npos; }));
}

}  // namespace
}  // namespace geond
