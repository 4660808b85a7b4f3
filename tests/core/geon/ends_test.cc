// SPDX-License-Identifier: Apache-2.0
#include "core/geon/ends.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "core/geon/one_view.h"
#include "core/geon/shape.h"
#include "tests/core/geon/random_geon.h"

namespace geond {
namespace {

Geon Make(GeonType type, const Eigen::Vector3d& size) {
  Geon geon;
  geon.type = type;
  geon.size = size;
  geon.X_TG = Pose(Eigen::Quaterniond(0.9, 0.2, -0.3, 0.1).normalized(), Eigen::Vector3d(0.3, -0.1, 0.2));
  if (IsTapered(type)) geon.taper = {0.3, 0.3};
  return geon;
}

// Samples for which `keep` of the point in G holds.
template <typename Keep>
PointCloud Part(const Geon& geon, int count, const Keep& keep) {
  const PointCloud all = SampleGeon(geon, count);
  std::vector<int> kept;
  for (std::size_t i = 0; i < all.size(); ++i)
    if (keep(Inverse(geon.X_TG) * all.points[i])) kept.push_back(static_cast<int>(i));
  return Select(all, kept);
}

FitOptions Only(GeonType type) {
  FitOptions options;
  options.types = {type};
  return options;
}

const GeonFit& OfType(const std::vector<GeonFit>& fits, GeonType type) {
  return *std::find_if(fits.begin(), fits.end(), [&](const GeonFit& f) { return f.geon.type == type; });
}

// Places on a ring just outside the end at +z, where the parts were cut apart.
std::vector<Eigen::Vector3d> Ring(const Geon& geon, double z, double radius) {
  std::vector<Eigen::Vector3d> ring;
  for (int i = 0; i < 40; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / 40;
    ring.push_back(geon.X_TG * Eigen::Vector3d(radius * std::cos(angle), radius * std::sin(angle), z));
  }
  return ring;
}

TEST(JudgeEnds, SeesAllEndsOfAWholeShape) {
  for (const GeonType type : kGeonTypes) {
    Draw draw(7);
    const std::vector<GeonFit> fits = FitGeons(SampleGeon(RandomGeon(type, draw), 600), Only(type));
    for (const auto& axis : fits.front().ends) {
      for (const EndState end : axis) EXPECT_EQ(end, EndState::kSeen) << GeonTypeName(type);
    }
    for (int k = 6; k < 9; ++k) EXPECT_TRUE(std::isfinite(fits.front().deviation[k])) << GeonTypeName(type);
  }
}

// A cylinder of which only a part of the side is there: nothing beyond it may be made up.
TEST(FitGeons, DoesNotInventTheLengthOfAnOpenTube) {
  const Geon tube = Make(GeonType::kCylinder, {0.02, 0.02, 0.05});
  const PointCloud part = Part(tube, 800, [](const Eigen::Vector3d& p) { return std::abs(p.z()) < 0.03; });
  const GeonFit fit = FitGeons(part, Only(GeonType::kCylinder)).front();
  EXPECT_EQ(fit.ends[2][0], EndState::kHidden);
  EXPECT_EQ(fit.ends[2][1], EndState::kHidden);
  EXPECT_NEAR(fit.geon.size.z(), 0.03, 0.0015);
  EXPECT_NEAR(fit.geon.size.x(), 0.02, 0.0005);
  EXPECT_TRUE(std::isinf(fit.deviation[8]));  // size and place along the axis
  EXPECT_TRUE(std::isinf(fit.deviation[2]));
}

TEST(FitGeons, TakesTheEndOfAPartAtItsCutForHidden) {
  const Geon stump = Make(GeonType::kTaperedCylinder, {0.026, 0.026, 0.014});
  const PointCloud part = Part(stump, 900, [](const Eigen::Vector3d& p) { return p.z() < 0.009; });
  Surroundings around;
  around.cuts = Ring(stump, 0.010, 0.031);
  const GeonFit fit = FitGeons(part, Only(GeonType::kTaperedCylinder), {}, {}, around).front();
  const int open = fit.ends[2][0] == EndState::kHidden ? 0 : 1;
  EXPECT_EQ(fit.ends[2][open], EndState::kHidden);
  EXPECT_EQ(fit.ends[2][1 - open], EndState::kSeen);
  EXPECT_NEAR(fit.geon.size.z(), 0.012, 0.0008);  // from -14 to +10 mm
  EXPECT_TRUE(std::isinf(fit.deviation[8]));
}

TEST(FitGeons, EmptyPlacesBoundAnEndThatNobodySaw) {
  const Geon box = Make(GeonType::kCuboid, {0.02, 0.03, 0.04});
  const PointCloud part = Part(box, 900, [](const Eigen::Vector3d& p) { return p.z() < 0.0385; });
  Draw draw(3);
  Surroundings around;
  for (int i = 0; i < 400; ++i) {
    const Eigen::Vector3d p(draw.Uniform(-0.03, 0.03), draw.Uniform(-0.045, 0.045), draw.Uniform(0.0405, 0.06));
    around.empty.push_back(box.X_TG * p);
  }
  const GeonFit fit = FitGeons(part, Only(GeonType::kCuboid), {}, {}, around).front();
  EXPECT_EQ(fit.geon.type, GeonType::kCuboid);
  EXPECT_NEAR(fit.geon.size.z(), 0.04, 3.0 * fit.deviation[8] + 0.0002);
  EXPECT_LT(fit.deviation[8], 0.1 * 0.04);
  EXPECT_TRUE(fit.ends[2][0] == EndState::kBounded || fit.ends[2][1] == EndState::kBounded);
}

// Two types that describe the points alike, of which one would stand where the scanner saw nothing.
TEST(FitGeons, CountsCoveredEmptyPlacesAgainstAFit) {
  const Geon disc = Make(GeonType::kCylinder, {0.03, 0.03, 0.02});
  const PointCloud face = Part(disc, 2400, [](const Eigen::Vector3d& p) { return p.z() > 0.0195; });
  Surroundings around;
  for (int i = 0; i < 200; ++i) {  // about the face, at all depths
    const double angle = 2.4 * i;
    around.empty.push_back(disc.X_TG *
                           Eigen::Vector3d(0.033 * std::cos(angle), 0.033 * std::sin(angle), 0.02 - 0.0002 * i));
  }
  const std::vector<GeonFit> fits = FitGeons(face, {}, {}, {}, around);
  EXPECT_GT(OfType(fits, GeonType::kCuboid).objective, 2.0 * OfType(fits, GeonType::kCylinder).objective);
}

TEST(FindOneView, FindsTheSideThatAllPointsWereSeenFromAndWhatIsBesideThem) {
  Draw draw(5);
  const Geon ball = Make(GeonType::kEllipsoid, {0.03, 0.03, 0.03});
  const Eigen::Vector3d to_sensor = draw.Normal3().normalized(), middle = ball.X_TG.translation();
  PointCloud half;
  const PointCloud all = SampleGeon(ball, 1500);
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (all.normals[i].dot(to_sensor) < 0.17) continue;
    half.points.push_back(all.points[i]);
    half.normals.push_back(all.normals[i]);
  }
  const OneView view = FindOneView(half.points, half.normals);
  EXPECT_GT(view.direction.dot(to_sensor), 0.98);
  EXPECT_GT(view.empty.size(), 50u);
  for (const Eigen::Vector3d& p : view.empty) {
    const Eigen::Vector3d d = p - middle;
    EXPECT_GT((d - d.dot(view.direction) * view.direction).norm(), 0.03);
  }
  EXPECT_TRUE(FindOneView(all.points, all.normals).direction.isZero());
}

}  // namespace
}  // namespace geond
