// SPDX-License-Identifier: Apache-2.0
#include "core/describe/relations.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace geond {
namespace {

Geon MakeGeon(GeonType type, Eigen::Vector3d size, Pose X_TG = {}) {
  Geon geon;
  geon.type = type;
  geon.size = size;
  geon.X_TG = X_TG;
  return geon;
}

// A square tube along z from z = 0 to 2, open at both ends, of two rings of squares: the lower is part 0, the upper part 1.
TriangleMesh TwoRings() {
  TriangleMesh mesh;
  for (int ring = 0; ring < 3; ++ring) {
    for (int k = 0; k < 4; ++k) {
      const double angle = std::numbers::pi / 4 + std::numbers::pi / 2 * k;
      mesh.vertices.push_back({std::cos(angle), std::sin(angle), static_cast<double>(ring)});
    }
  }
  for (int ring = 0; ring < 2; ++ring) {
    for (int k = 0; k < 4; ++k) {
      const int a = 4 * ring + k, b = 4 * ring + (k + 1) % 4;
      mesh.triangles.push_back({a, b, b + 4});
      mesh.triangles.push_back({a, b + 4, a + 4});
    }
  }
  return mesh;
}

struct TwoParts {
  TriangleMesh mesh = TwoRings();
  PartSegmentation segmentation;
  std::vector<PointCloud> clouds{2};
  std::vector<std::vector<GeonFit>> fits{2};

  TwoParts() {
    segmentation.n_parts = 2;
    segmentation.labels.assign(16, 0);
    for (int t = 8; t < 16; ++t) segmentation.labels[t] = 1;
    segmentation.boundaries = {{.a = 0, .b = 1, .length = 4 * std::sqrt(2.0), .closed = true, .strength = 0.4}};
    segmentation.significance = {0.2, 0.7};
    for (PointCloud& cloud : clouds) cloud.points = {{-1, -1, -1}, {1, 1, 1}};
    fits[0].resize(1);
    fits[0][0].geon = MakeGeon(GeonType::kCuboid, {1, 1, 2}, Pose::Translation({0, 0, -1}));
    fits[1].resize(1);
    fits[1][0].geon = MakeGeon(GeonType::kCylinder, {0.5, 0.5, 1}, Pose::Translation({0, 0, 2}));
  }
  ObjectDescription Describe() const { return DescribeParts(mesh, segmentation, clouds, fits); }
};

TEST(GeonVolume, EqualsTheSolidsOfGeometry) {
  EXPECT_DOUBLE_EQ(GeonVolume(MakeGeon(GeonType::kEllipsoid, {1, 2, 3})), 8 * std::numbers::pi);
  EXPECT_DOUBLE_EQ(GeonVolume(MakeGeon(GeonType::kCylinder, {1, 1, 3})), 6 * std::numbers::pi);
  EXPECT_DOUBLE_EQ(GeonVolume(MakeGeon(GeonType::kCuboid, {1, 2, 3})), 48);
  Geon cone = MakeGeon(GeonType::kTaperedCylinder, {1, 1, 3});
  cone.taper = {1, 1};  // radius 0 below, 2 above, height 6: pi 4 6 / 3
  EXPECT_DOUBLE_EQ(GeonVolume(cone), 8 * std::numbers::pi);
}

TEST(IsAtEnd, TellsEndsFromSides) {
  const Geon rod = MakeGeon(GeonType::kCylinder, {1, 1, 5}, Pose::Rotation({0, 1, 0}, std::numbers::pi / 2));
  EXPECT_TRUE(IsAtEnd(rod, {5, 0, 0}));
  EXPECT_FALSE(IsAtEnd(rod, {1, 0, 1}));
  // The axis of a cuboid is its longest.
  EXPECT_TRUE(IsAtEnd(MakeGeon(GeonType::kCuboid, {5, 1, 1}), {5, 0.5, 0}));
  EXPECT_FALSE(IsAtEnd(MakeGeon(GeonType::kCuboid, {5, 1, 1}), {0, 0.1, 1}));
  // A ball has no side.
  EXPECT_TRUE(IsAtEnd(MakeGeon(GeonType::kEllipsoid, {1, 1, 1}), {1, 0, 0}));
}

TEST(IsAtEnd, FollowsTheBentAxis) {
  Geon bent = MakeGeon(GeonType::kCurvedCylinder, {0.2, 0.2, std::numbers::pi / 2});
  bent.bend = 1.0;  // a half circle about (1, 0, 0): its ends are at (1, 0, +-1)
  EXPECT_TRUE(IsAtEnd(bent, {1, 0, 1}));
  EXPECT_FALSE(IsAtEnd(bent, {0.25, 0, 0}));
}

TEST(RelateParts, SaysHowACylinderStandsOnABox) {
  const PartRelation relation = TwoParts().Describe().relations.at(0);
  EXPECT_EQ(relation.a, 1);
  EXPECT_EQ(relation.b, 2);
  EXPECT_TRUE(relation.touching);
  EXPECT_NEAR((relation.contact - Eigen::Vector3d(0, 0, 1)).norm(), 0, 1e-12);
  EXPECT_NEAR((relation.direction - Eigen::Vector3d(0, 0, 1)).norm(), 0, 1e-12);
  EXPECT_DOUBLE_EQ(relation.distance, 3);
  EXPECT_NEAR(relation.boundary_length, 4 * std::sqrt(2.0), 1e-12);
  EXPECT_DOUBLE_EQ(relation.boundary_strength, 0.4);
  EXPECT_EQ(relation.vertical, "above");
  EXPECT_EQ(relation.joint, "end_to_end");
  EXPECT_EQ(relation.sentence,
            "part 2 (cylinder) is above part 1 (cuboid), joined end to end, and is smaller");
}

TEST(RelateParts, TurningUpsideDownSwapsAboveAndBelow) {
  TwoParts object;
  const Pose turned = Pose::Rotation({1, 0, 0}, std::numbers::pi);
  object.mesh = Transform(turned, object.mesh);
  for (auto& fits : object.fits) fits[0].geon.X_TG = turned * fits[0].geon.X_TG;
  const PartRelation relation = object.Describe().relations.at(0);
  EXPECT_EQ(relation.vertical, "below");
  EXPECT_EQ(relation.joint, "end_to_end");
}

TEST(RelateParts, PartsApartAreRelatedToTheNearest) {
  TwoParts object;
  object.mesh.triangles[8] = object.mesh.triangles[15];  // no longer one surface: the rings share no edge
  for (int t = 8; t < 16; ++t) {
    for (int& v : object.mesh.triangles[t]) v += 12;
  }
  const std::vector<Eigen::Vector3d> vertices = object.mesh.vertices;
  for (const Eigen::Vector3d& v : vertices) object.mesh.vertices.push_back(v + Eigen::Vector3d(0, 0, 3));
  const ObjectDescription description = object.Describe();
  ASSERT_EQ(description.relations.size(), 1u);
  EXPECT_FALSE(description.relations[0].touching);
  EXPECT_EQ(description.relations[0].boundary_length, 0.0);
}

TEST(DescribeParts, LeavesOutAPartWithoutFitsAndSaysSo) {
  TwoParts object;
  object.fits[1].clear();
  const ObjectDescription description = object.Describe();
  EXPECT_EQ(description.parts.size(), 1u);
  EXPECT_TRUE(description.relations.empty());
  ASSERT_EQ(description.notes.size(), 1u);
  EXPECT_NE(description.notes[0].find("part 2"), std::string::npos);
}

TEST(DescribeParts, SaysThatAPartIsLikeNoneOfTheShapes) {
  TwoParts object;
  object.fits[1][0].residual = 0.5;
  const ObjectDescription description = object.Describe();
  EXPECT_EQ(description.parts.size(), 2u);
  ASSERT_EQ(description.notes.size(), 1u);
  EXPECT_NE(description.notes[0].find("part 2 is like none"), std::string::npos);
}

TEST(DescribeParts, RefusesFitsOfAnotherObject) {
  TwoParts object;
  object.fits.pop_back();
  EXPECT_THROW(object.Describe(), std::invalid_argument);
}

TEST(ToJson, HasLengthsInMillimetresOnOneLine) {
  TwoParts object;
  object.fits[1][0].residual = 0.0002;
  object.fits[1][0].ends[2][0] = EndState::kHidden;
  object.fits[1][0].margin = std::numeric_limits<double>::infinity();
  const std::string text = ToJson(object.Describe());
  EXPECT_EQ(text.find('\n'), std::string::npos);
  const nlohmann::json json = nlohmann::json::parse(text);
  EXPECT_EQ(json["n_parts"], 2);
  const nlohmann::json& part = json["parts"][1];
  EXPECT_EQ(part["id"], 2);
  EXPECT_EQ(part["type"], "cylinder");
  EXPECT_EQ(part["type_index"], 2);
  EXPECT_DOUBLE_EQ(part["size_mm"][2], 1000.0);
  EXPECT_DOUBLE_EQ(part["pose"]["position_mm"][2], 2000.0);
  EXPECT_DOUBLE_EQ(part["pose"]["quaternion"]["w"], 1.0);
  EXPECT_DOUBLE_EQ(part["residual_mm"], 0.2);
  EXPECT_TRUE(part["margin"].is_null());
  EXPECT_EQ(part["size_at_least"], nlohmann::json({false, false, true}));
  EXPECT_EQ(part["ends"]["z"], nlohmann::json({"hidden", "seen"}));
  EXPECT_EQ(part["ends"]["x"], nlohmann::json({"seen", "seen"}));
  EXPECT_NE(ToText(object.Describe()).find("500.0 x 500.0 x at least 1000.0 mm"), std::string::npos);
  EXPECT_EQ(part["all_models"].size(), 1u);
  for (const char* key : {"taper", "bend_per_mm", "t1_mm", "t2", "confidence", "points"}) EXPECT_TRUE(part.contains(key)) << key;
  EXPECT_EQ(json["relations"].size(), 1u);
  EXPECT_TRUE(json.contains("version"));
  EXPECT_TRUE(json.contains("seconds"));
}

}  // namespace
}  // namespace geond
