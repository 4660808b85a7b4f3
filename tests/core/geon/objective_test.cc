// SPDX-License-Identifier: Apache-2.0
#include "core/geon/objective.h"

#include <cmath>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/geon/misfit.h"
#include "core/geon/shape.h"
#include "tests/core/geon/geon_cases.h"
#include "tests/core/geon/random_geon.h"

namespace geond {
namespace {

const std::vector<std::string> kCaseNames = {"1_ellipsoid", "2_cylinder", "3_cuboid", "4_tap_cyl",
                                             "5_tap_cub",   "6_cur_cyl",  "7_cur_cub"};

LanePoints LanesOf(const PointCloud& cloud) {
  LanePoints points(static_cast<int>(cloud.size()));
  for (std::size_t i = 0; i < cloud.size(); ++i) points.Set(static_cast<int>(i), cloud.points[i], cloud.normals[i]);
  return points;
}

// Values of an independent implementation, in full doubles.
TEST(PointErrors, AgreeWithTheReferenceCases) {
  for (const std::string& name : kCaseNames) {
    const auto file = ReadJson(GEOND_TEST_DATA "/geon/geon_" + name + ".json");
    const int type = file.at("type");
    for (const auto& item : file.at("cases")) {
      const Geon geon = GeonOfCase(type, item.at("p"));
      const PointCloud cloud = CloudOfCase(item);
      const double scale = geon.size.norm();
      const std::vector<PointError> errors = PointErrors(geon, cloud);
      for (std::size_t i = 0; i < errors.size(); ++i) {
        const double e = item.at("e")[i];
        EXPECT_NEAR(errors[i].e, e, 1e-10 * std::max(scale * 1e-3, std::abs(e)) + 1e-13 * scale) << name << " point " << i;
        const auto& n = item.at("n_model")[i];
        EXPECT_LT((errors[i].model_normal - Eigen::Vector3d(n[0], n[1], n[2])).norm(), 1e-10) << name << " point " << i;
      }
      const auto& expected = item.at("objective").at("thesis");
      const Objective objective = EvaluateObjective(geon, cloud, 5.0);
      const auto near = [&](double value, double reference, double unit) {
        EXPECT_NEAR(value, reference, 1e-10 * std::abs(reference) + 1e-14 * unit) << name;
      };
      near(objective.t1, expected.at("t1"), scale);
      near(objective.t2, expected.at("t2"), 1.0);
      near(objective.value, expected.at("E"), scale * 5);
      near(objective.distance, item.at("objective").at("tangent_plane").at("t1"), scale);
    }
  }
}

TEST(PointErrors, HoldForAHalfBendingAngleAboveNinetyDegrees) {
  const auto file = ReadJson(GEOND_TEST_DATA "/geon/geon_strong_bend.json");
  const Geon geon = GeonOfCase(6, file.at("p"));
  const PointCloud cloud = CloudOfCase(file);
  ASSERT_GT(geon.bend * geon.size.z(), 2.0);
  const std::vector<PointError> errors = PointErrors(geon, cloud);
  for (std::size_t i = 0; i < errors.size(); ++i) {
    EXPECT_NEAR(errors[i].e, file.at("e")[i], 1e-10);
    EXPECT_NEAR(errors[i].model_normal.dot(cloud.normals[i]), 1.0, 1e-10);
  }
}

TEST(PointErrors, TakeTheCentreForTheDeepestPoint) {
  const Geon geon{.type = GeonType::kCuboid, .size = {3.0, 2.0, 4.0}};
  PointCloud centre;
  centre.points = {Eigen::Vector3d::Zero()};
  centre.normals = {Eigen::Vector3d::UnitX()};
  EXPECT_EQ(PointErrors(geon, centre)[0].e, -2.0);
}

// For small offsets along the normal the first-order distance is the offset (correction 11: the ray overstates it).
TEST(PointErrors, FirstOrderDistanceIsTheTrueOneNearTheSurface) {
  Draw draw(11);
  for (const GeonType type : kGeonTypes) {
    const Geon geon = RandomGeon(type, draw);
    PointCloud cloud = SampleGeon(geon, 200);
    const double offset = 1e-5 * geon.size.minCoeff();
    for (std::size_t i = 0; i < cloud.size(); ++i) cloud.points[i] += offset * cloud.normals[i];
    for (const PointError& error : PointErrors(geon, cloud)) {
      EXPECT_NEAR(error.distance, offset, 0.02 * offset);
    }
  }
}

class EveryMisfit : public testing::TestWithParam<GeonType> {
 protected:
  // Points about a geon, some far off, with normals a little wrong.
  void Make(std::uint64_t seed) {
    Draw draw(seed);
    geon = RandomGeon(GetParam(), draw, 1.0);
    cloud = SampleGeon(geon, 61);
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      cloud.points[i] += 0.2 * draw.Normal3();
      cloud.normals[i] = (cloud.normals[i] + 0.2 * draw.Normal3()).normalized();
    }
    geon.size += 0.1 * draw.Normal3();
    geon.X_TG = geon.X_TG * Pose(Eigen::Quaterniond(1, 0.1, -0.05, 0.08), Eigen::Vector3d(0.1, -0.2, 0.1));
    points = LanesOf(cloud);
  }
  Geon geon;
  PointCloud cloud;
  LanePoints points;
};
INSTANTIATE_TEST_SUITE_P(Misfit, EveryMisfit, testing::ValuesIn(kGeonTypes),
                         [](const auto& type) { return std::string(GeonTypeName(type.param)); });

TEST_P(EveryMisfit, AgreesWithThePointByPointForm) {
  for (std::uint64_t seed = 20; seed < 40; ++seed) {
    Make(seed);
    const Objective objective = EvaluateObjective(geon, cloud, 5.0);
    const MisfitSums sums = SumMisfit(StateOf(geon), points);
    const double n = static_cast<double>(cloud.size());
    EXPECT_EQ(sums.weight, n);
    EXPECT_NEAR(sums.distance / n, objective.t1, 1e-13 * objective.t1);
    EXPECT_NEAR(sums.normal / n, objective.t2, 1e-13 * objective.t2);
    // ... and point by point.
    const std::vector<PointError> errors = PointErrors(geon, cloud);
    for (std::size_t i = 0; i < errors.size(); i += 7) {
      const MisfitSums one = SumMisfit(StateOf(geon), LanesOf(Select(cloud, {static_cast<int>(i)})));
      EXPECT_NEAR(one.distance, std::abs(errors[i].e), 1e-12 * std::max(1.0, std::abs(errors[i].e)));
      EXPECT_NEAR(one.normal, (errors[i].model_normal - cloud.normals[i]).squaredNorm(), 1e-12);
    }
  }
}

// The state moved by `step` along the parameters: rotation, position, size, deformation.
GeonState Moved(const GeonState& state, const ParameterVector& step) {
  GeonState moved = state;
  const Eigen::Vector3d w = step.head<3>();
  if (w.norm() > 0) moved.rotation = state.rotation * Eigen::AngleAxisd(w.norm(), w.normalized()).toRotationMatrix();
  moved.center += state.rotation * step.segment<3>(3);
  moved.size += step.segment<3>(6);
  moved.deformation += step.tail<2>();
  return moved;
}

TEST_P(EveryMisfit, DerivativesAgreeWithDifferences) {
  for (std::uint64_t seed = 40; seed < 60; ++seed) {
    Make(seed);
    const GeonState state = StateOf(geon);
    const int count = ParameterCount(GetParam());
    MisfitDerivatives d;
    DifferentiateMisfit(state, points, 3.0, 1e-12, d);
    // With the distances weighted by 1/|e| the gradient of their sum is sum sign(e) J_e.
    const double h = 1e-6;
    for (int k = 0; k < count; ++k) {
      const ParameterVector step = h * ParameterVector::Unit(k);
      const MisfitSums up = SumMisfit(Moved(state, step), points), down = SumMisfit(Moved(state, -step), points);
      const double by_distance = (up.distance - down.distance) / (2 * h), by_normal = (up.normal - down.normal) / (4 * h);
      const double unit = std::sqrt(d.hessian(k, k) * cloud.size());
      EXPECT_NEAR(d.distance_gradient[k], by_distance, 1e-6 * unit) << "parameter " << k << " seed " << seed;
      EXPECT_NEAR(d.normal_gradient[k], by_normal, 1e-6 * unit) << "parameter " << k << " seed " << seed;
    }
  }
}

TEST_P(EveryMisfit, HessianIsTheSumOfTheSquaresOfEachPointsDerivatives) {
  Make(60);
  const GeonState state = StateOf(geon);
  const int count = ParameterCount(GetParam()), n = static_cast<int>(cloud.size());
  const double normal_weight = 3.0, floor = 0.05, h = 1e-6;
  MisfitDerivatives d;
  DifferentiateMisfit(state, points, normal_weight, floor, d);
  // Residuals in T of both sides, by the point-by-point form.
  const auto residuals = [&](const ParameterVector& step) {
    const Geon moved = GeonOf(Moved(state, step));
    Eigen::MatrixXd r(4, n);
    const std::vector<PointError> errors = PointErrors(moved, cloud);
    for (int i = 0; i < n; ++i) {
      r(0, i) = errors[i].e;
      r.col(i).tail<3>() = errors[i].model_normal - cloud.normals[i];
    }
    return r;
  };
  const Eigen::MatrixXd at = residuals(ParameterVector::Zero());
  std::vector<Eigen::MatrixXd> slope;
  for (int k = 0; k < count; ++k) {
    const ParameterVector step = h * ParameterVector::Unit(k);
    slope.push_back((residuals(step) - residuals(-step)) / (2 * h));
  }
  for (int j = 0; j < count; ++j) {
    for (int k = 0; k < count; ++k) {
      double sum = 0.0;
      for (int i = 0; i < n; ++i) {
        sum += slope[j](0, i) * slope[k](0, i) / std::max(floor, std::abs(at(0, i))) +
               normal_weight * slope[j].col(i).tail<3>().dot(slope[k].col(i).tail<3>());
      }
      EXPECT_NEAR(d.hessian(j, k), sum, 1e-6 * std::sqrt(d.hessian(j, j) * d.hessian(k, k))) << j << " " << k;
    }
  }
}

TEST_P(EveryMisfit, EmptyPlacesCountByTheirDepthInsideAndNotOutside) {
  Draw draw(61);
  Make(61);
  const GeonState state = StateOf(geon);
  const MisfitSums without = SumMisfit(state, points, 0.01);
  std::vector<Eigen::Vector3d> places;
  for (int i = 0; i < 50; ++i) places.push_back(geon.X_TG * Eigen::Vector3d(1.5 * draw.Normal3()));
  double depth = 0.0;
  PointCloud cloud_of_places;
  cloud_of_places.points = places;
  cloud_of_places.normals.assign(places.size(), Eigen::Vector3d::UnitX());
  for (const PointError& error : PointErrors(geon, cloud_of_places)) depth += std::max(0.0, -error.e);
  ASSERT_GT(depth, 0.0);
  points.AddEmpty(places, 10.0);
  const MisfitSums with = SumMisfit(state, points, 1e-12);
  EXPECT_EQ(with.weight, without.weight);
  EXPECT_EQ(with.distance, without.distance);
  EXPECT_EQ(with.normal, without.normal);
  EXPECT_NEAR(with.covered, depth * 10.0 / 50.0, 1e-12 * depth);
  // The slope of the smooth sum, through the floor.
  MisfitDerivatives d;
  const double floor = 0.1, h = 1e-6;
  DifferentiateMisfit(state, points, 0.0, floor, d);
  for (int k = 0; k < ParameterCount(GetParam()); ++k) {
    const ParameterVector step = h * ParameterVector::Unit(k);
    const double slope = (SumMisfit(Moved(state, step), points, floor).smooth -
                          SumMisfit(Moved(state, -step), points, floor).smooth) / (2 * h);
    EXPECT_NEAR(d.distance_gradient[k], slope, 1e-6 * std::sqrt(d.hessian(k, k) * cloud.size())) << k;
  }
}

}  // namespace
}  // namespace geond
