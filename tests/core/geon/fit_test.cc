// SPDX-License-Identifier: Apache-2.0
#include "core/geon/fit.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/geon/objective.h"
#include "core/geon/shape.h"
#include "tests/core/geon/geon_cases.h"
#include "tests/core/geon/random_geon.h"

namespace geond {
namespace {

// Samples of a geon with noise of `share` of the diagonal of its sizes along the normals, and normals a little wrong.
PointCloud NoisySamples(const Geon& geon, int count, double share, Draw& draw) {
  PointCloud cloud = SampleGeon(geon, count);
  const double sigma = share * 2.0 * geon.size.norm();
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    cloud.points[i] += sigma * draw.Normal() * cloud.normals[i];
    cloud.normals[i] = (cloud.normals[i] + 8.0 * share * draw.Normal3()).normalized();
  }
  return cloud;
}

class EveryFit : public testing::TestWithParam<GeonType> {};
INSTANTIATE_TEST_SUITE_P(Fit, EveryFit, testing::ValuesIn(kGeonTypes),
                         [](const auto& type) { return std::string(GeonTypeName(type.param)); });

TEST_P(EveryFit, FindsTypeAndParametersOfExactSamples) {
  Draw draw(100);
  const Geon truth = Canonical(RandomGeon(GetParam(), draw));
  const std::vector<GeonFit> fits = FitGeons(SampleGeon(truth, 400));
  ASSERT_EQ(fits.size(), kGeonTypes.size());
  const Geon& found = fits.front().geon;
  EXPECT_EQ(found.type, truth.type);
  const double scale = truth.size.norm();
  EXPECT_LT((found.size - truth.size).norm(), 1e-6 * scale);
  EXPECT_LT((found.X_TG.translation() - truth.X_TG.translation()).norm(), 1e-6 * scale);
  EXPECT_LT(found.X_TG.rotation().angularDistance(truth.X_TG.rotation()), 1e-5);
  EXPECT_LT((found.taper - truth.taper).norm(), 1e-6);
  EXPECT_NEAR(found.bend * scale, truth.bend * scale, 1e-5);
  EXPECT_LT(fits.front().residual, 1e-7 * scale);
  EXPECT_GT(fits.front().margin, 1.5);
}

TEST_P(EveryFit, FindsTypeAndSizesThroughNoise) {
  Draw draw(101);
  for (int i = 0; i < 3; ++i) {
    const Geon truth = Canonical(RandomGeon(GetParam(), draw));
    const std::vector<GeonFit> fits = FitGeons(NoisySamples(truth, 400, 0.005, draw));
    EXPECT_EQ(fits.front().geon.type, truth.type);
    EXPECT_LT((fits.front().geon.size - truth.size).norm(), 0.06 * truth.size.norm());
    EXPECT_LT((fits.front().geon.X_TG.translation() - truth.X_TG.translation()).norm(), 0.03 * truth.size.norm());
    EXPECT_NEAR(fits.front().residual, 0.005 * 2.0 * truth.size.norm() * std::sqrt(2.0 / 3.14159), 0.15 * fits.front().residual);
  }
}

// Rotations that leave `a` the same shape up to small differences make the comparison one of surfaces.
double SurfaceDifference(const Geon& a, const Geon& b) {
  double worst = 0.0;
  const PointCloud samples = SampleGeon(a, 100);
  for (const PointError& error : PointErrors(b, samples)) worst = std::max(worst, std::abs(error.e));
  return worst / a.size.norm();
}

TEST_P(EveryFit, DoesNotDependOnPlaceTurnScaleOrOrder) {
  Draw draw(102);
  const Geon truth = RandomGeon(GetParam(), draw);
  const PointCloud part = NoisySamples(truth, 300, 0.01, draw);
  const std::vector<GeonFit> fits = FitGeons(part);
  for (int i = 0; i < 3; ++i) {
    const Eigen::Quaterniond turn = draw.Rotation();
    const Pose X(turn, Eigen::Vector3d(0.2, -1.0, 0.4));
    const double factor = i == 1 ? 1000.0 : 1.0;
    std::vector<int> order(part.size());
    std::iota(order.begin(), order.end(), 0);
    if (i > 0) std::sort(order.begin(), order.end(), [](int a, int b) { return a * 7919 % 300 < b * 7919 % 300; });
    PointCloud moved = Select(Transform(X, part), order);
    for (Eigen::Vector3d& p : moved.points) p *= factor;
    const std::vector<GeonFit> again = FitGeons(moved);
    ASSERT_EQ(again.front().geon.type, fits.front().geon.type);
    Geon back = again.front().geon;
    back.X_TG = Inverse(X) * Pose(back.X_TG.rotation(), back.X_TG.translation() / factor);
    back.size /= factor;
    back.bend *= factor;
    EXPECT_LT((back.size - fits.front().geon.size).norm(), 1e-6 * back.size.norm());
    EXPECT_LT(SurfaceDifference(fits.front().geon, back), 1e-6);
    for (std::size_t k = 0; k < fits.size(); ++k) {
      EXPECT_EQ(again[k].geon.type, fits[k].geon.type);
      EXPECT_NEAR(again[k].objective / factor, fits[k].objective, 1e-6 * fits[k].objective);
    }
  }
}

TEST(FitGeons, GivesTheSameBitsForAnyNumberOfThreads) {
  Draw draw(103);
  const PointCloud part = NoisySamples(RandomGeon(GeonType::kCurvedCuboid, draw), 200, 0.01, draw);
  FitOptions options;
  options.threads = 1;
  const std::vector<GeonFit> one = FitGeons(part, options);
  options.threads = 3;
  const std::vector<GeonFit> three = FitGeons(part, options);
  for (std::size_t i = 0; i < one.size(); ++i) {
    EXPECT_EQ(one[i].geon.type, three[i].geon.type);
    EXPECT_EQ(one[i].objective, three[i].objective);
    EXPECT_EQ(one[i].geon.size, three[i].geon.size);
    EXPECT_EQ(one[i].geon.X_TG.translation(), three[i].geon.X_TG.translation());
  }
}

TEST(FitGeons, FindsTheTypesOfTheReferenceScans) {
  const auto file = ReadJson(GEOND_TEST_DATA "/geon/fit_cases.json");
  for (const auto& item : file.at("fits")) {
    const PointCloud part = CloudOfCase(item);
    const int type = item.at("type");
    EXPECT_EQ(static_cast<int>(FitGeons(part).front().geon.type), type);
    // The best known are of the thesis' objective alone.
    FitOptions alone;
    alone.outline_of_one_view = false;
    for (const GeonFit& fit : FitGeons(part, alone)) {
      if (static_cast<int>(fit.geon.type) != type) continue;
      EXPECT_LE(fit.objective, 1.01 * item.at("best_known").at(std::to_string(type)).at("E").get<double>());
    }
  }
}

TEST(FitGeons, SearchesThoroughlyWhenAsked) {
  const auto file = ReadJson(GEOND_TEST_DATA "/geon/fit_cases.json");
  const auto& item = file.at("fits").at(4);
  FitOptions options;
  options.outline_of_one_view = false;
  options.types = {GeonType::kEllipsoid, GeonType::kCuboid};
  const PointCloud part = CloudOfCase(item);
  const std::vector<GeonFit> quick = FitGeons(part, options);
  options.thorough = true;
  options.least_gamma = 0.005;   // shapes that shrink to a point are allowed, as the best known of some wrong types did
  const std::vector<GeonFit> all = FitGeons(part, options);
  for (std::size_t i = 0; i < all.size(); ++i) {
    ASSERT_EQ(all[i].geon.type, quick[i].geon.type);
    EXPECT_LE(all[i].objective, quick[i].objective * (1.0 + 1e-6));
    const std::string type = std::to_string(static_cast<int>(all[i].geon.type));
    EXPECT_LE(all[i].objective, 1.01 * item.at("best_known").at(type).at("E").get<double>());
    EXPECT_GT(all[i].evaluations, quick[i].evaluations);
  }
}

TEST(FitGeons, DropsDuplicatesAndPointsThatAreNotFiniteAndCountsThem) {
  Draw draw(104);
  const PointCloud good = NoisySamples(RandomGeon(GeonType::kCuboid, draw), 200, 0.01, draw);
  PointCloud bad = good;
  bad.points.push_back(Eigen::Vector3d(std::numeric_limits<double>::quiet_NaN(), 0, 0));
  bad.normals.push_back(Eigen::Vector3d::UnitX());
  bad.points.push_back(Eigen::Vector3d(0.1, 0.1, 0.1));
  bad.normals.push_back(Eigen::Vector3d::Zero());
  for (int i = 0; i < 5; ++i) {
    bad.points.push_back(good.points[i]);
    bad.normals.push_back(good.normals[i]);
  }
  const std::vector<GeonFit> fits = FitGeons(bad);
  EXPECT_EQ(fits.front().points, 200);
  EXPECT_EQ(fits.front().points_dropped, 7);
  EXPECT_EQ(fits.front().geon.type, GeonType::kCuboid);
}

TEST(FitGeons, RefusesWhatCannotBeFitted) {
  Draw draw(105);
  PointCloud part = SampleGeon(RandomGeon(GeonType::kCylinder, draw), 11);
  EXPECT_THROW(FitGeons(part), std::invalid_argument);
  part = SampleGeon(RandomGeon(GeonType::kCylinder, draw), 100);
  part.normals.clear();
  EXPECT_THROW(FitGeons(part), std::invalid_argument);
  EXPECT_THROW(FitGeons(PointCloud{}), std::invalid_argument);
  part.points.assign(100, Eigen::Vector3d(1, 2, 3));
  part.normals.assign(100, Eigen::Vector3d::UnitX());
  EXPECT_THROW(FitGeons(part), std::invalid_argument);
  part = SampleGeon(RandomGeon(GeonType::kCylinder, draw), 100);
  FitOptions options;
  options.types.clear();
  EXPECT_THROW(FitGeons(part, options), std::invalid_argument);
}

TEST(FitGeons, StopsWhenAsked) {
  Draw draw(106);
  std::stop_source source;
  source.request_stop();
  EXPECT_THROW(FitGeons(SampleGeon(RandomGeon(GeonType::kCuboid, draw), 100), {}, source.get_token()), Cancelled);
}

TEST(FitGeons, FitsOnlyTheTypesAskedFor) {
  Draw draw(107);
  FitOptions options;
  options.types = {GeonType::kCuboid, GeonType::kEllipsoid};
  const auto fits = FitGeons(SampleGeon(RandomGeon(GeonType::kEllipsoid, draw), 100), options);
  ASSERT_EQ(fits.size(), 2u);
  EXPECT_EQ(fits[0].geon.type, GeonType::kEllipsoid);
  EXPECT_EQ(fits[1].geon.type, GeonType::kCuboid);
}

}  // namespace
}  // namespace geond
