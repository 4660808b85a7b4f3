// SPDX-License-Identifier: Apache-2.0
#include "core/charge/potential.h"

#include <cmath>
#include <fstream>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/charge/kernels.h"
#include "core/charge/panels.h"

namespace geond {
namespace {

using Eigen::Vector3d;

Vector3d ToVector(const nlohmann::json& values) {
  return Vector3d(values[0].get<double>(), values[1].get<double>(), values[2].get<double>());
}

struct Random {
  std::mt19937_64 engine{7};
  double operator()() { return static_cast<double>(engine() >> 11) * 0x1p-52 - 1.0; }
  Vector3d Vector() { return {(*this)(), (*this)(), (*this)()}; }
};

TEST(TrianglePotential, AgreesWithFortyDigitsWhereverThePointLies) {
  std::ifstream file(GEOND_TEST_DATA "/potential.json");
  ASSERT_TRUE(file);
  const nlohmann::json json = nlohmann::json::parse(file);
  ASSERT_EQ(json.at("cases").size(), 30u);
  for (const auto& placed : json.at("cases")) {
    const double exact = std::stod(placed["value"].get<std::string>());
    const double value = TrianglePotential(ToVector(placed["r"]), ToVector(placed["v"][0]), ToVector(placed["v"][1]),
                                           ToVector(placed["v"][2]));
    EXPECT_NEAR(value / exact, 1.0, 1e-13) << placed["name"];
  }
}

TEST(TrianglePotential, OfATriangleCutInFourIsTheSum) {
  Random random;
  for (int i = 0; i < 200; ++i) {
    const Vector3d a = random.Vector(), b = random.Vector(), c = random.Vector(), r = 2.0 * random.Vector();
    const Vector3d ab = (a + b) / 2, bc = (b + c) / 2, ca = (c + a) / 2;
    const double parts = TrianglePotential(r, a, ab, ca) + TrianglePotential(r, b, bc, ab) +
                         TrianglePotential(r, c, ca, bc) + TrianglePotential(r, ab, bc, ca);
    EXPECT_NEAR(TrianglePotential(r, a, b, c) / parts, 1.0, 1e-12);
  }
}

TEST(TrianglePotential, GrowsWithTheScaleAndIsTheSameFromBothSidesAndInAnyOrderOfCorners) {
  Random random;
  for (int i = 0; i < 100; ++i) {
    const Vector3d a = random.Vector(), b = random.Vector(), c = random.Vector(), r = random.Vector();
    const double value = TrianglePotential(r, a, b, c);
    EXPECT_NEAR(TrianglePotential(1e-3 * r, 1e-3 * a, 1e-3 * b, 1e-3 * c), 1e-3 * value, 1e-15 * value);
    EXPECT_NEAR(TrianglePotential(r, b, c, a), value, 1e-13 * value);
    EXPECT_NEAR(TrianglePotential(r, b, a, c), value, 1e-13 * value);
    const Vector3d n = (b - a).cross(c - a).normalized();
    EXPECT_NEAR(TrianglePotential(r - 2.0 * n.dot(r - a) * n, a, b, c), value, 1e-12 * value);
  }
}

TEST(TrianglePotential, FarAwayIsThatOfAPointCharge) {
  const Vector3d a(0, 0, 0), b(1, 0, 0), c(0, 2, 0), centroid = (a + b + c) / 3;
  const double value = TrianglePotential(centroid + Vector3d(300, 500, 800), a, b, c);
  EXPECT_NEAR(value * std::sqrt(980000.0), 1.0, 1e-6);
}

TEST(TrianglePotential, OfATriangleWithoutAreaIsNothing) {
  EXPECT_EQ(TrianglePotential({0, 0, 1}, {0, 0, 0}, {1, 0, 0}, {2, 0, 0}), 0.0);
}

TEST(Kernels, EveryInstructionSetGivesThePotentialOfTheScalarCode) {
  Random random;
  std::vector<double> x, y, z;
  const Vector3d a(0.1, 0.2, 0.3), b(1.1, 0.1, 0.4), c(0.4, 0.9, -0.1);
  std::vector<Vector3d> points = {a, b, c, (a + b) / 2, (a + b + c) / 3, a + 3.0 * (b - a), a - 1e-9 * (c - a)};
  while (points.size() < 997) points.push_back(std::exp(4.0 * random()) * random.Vector());
  for (const Vector3d& p : points) x.push_back(p.x()), y.push_back(p.y()), z.push_back(p.z());
  const charge::TriangleFrame frame = charge::MakeTriangleFrame(a, b, c);
  std::vector<double> first;
  for (const charge::Kernels* kernels : charge::UsableKernels()) {
    std::vector<double> out(points.size());
    kernels->double_precision.triangle_potential(frame, x.data(), y.data(), z.data(), static_cast<int>(out.size()),
                                                 out.data());
    for (std::size_t i = 0; i < out.size(); ++i) {
      const double scalar = TrianglePotential(points[i], a, b, c);
      EXPECT_NEAR(out[i] / scalar, 1.0, 1e-13 * (1.0 + points[i].norm())) << kernels->name << " point " << i;
    }
    if (first.empty()) first = out;
    EXPECT_THAT(out, testing::ContainerEq(first)) << kernels->name;
  }
}

TEST(Kernels, EveryInstructionSetGivesThePotentialNearByInSinglePrecisionToo) {
  Random random;
  const Vector3d a(-0.5, -0.3, 0.1), b(0.6, -0.2, 0.0), c(-0.1, 0.5, -0.1);
  std::vector<Vector3d> points = {a, b, c, (a + b) / 2, (a + b + c) / 3, b + 0.5 * (b - a)};
  while (points.size() < 997) points.push_back(random.Vector());
  std::vector<float> x, y, z;
  for (const Vector3d& p : points) x.push_back(p.x()), y.push_back(p.y()), z.push_back(p.z());
  TriangleMesh mesh;
  mesh.vertices = {a, b, c};
  mesh.triangles = {{0, 1, 2}};
  const auto frame = charge::LocalFrameOf<float>(mesh, 0, Vector3d::Zero());
  const double greatest = TrianglePotential((a + b + c) / 3, a, b, c);
  for (const charge::Kernels* kernels : charge::UsableKernels()) {
    std::vector<float> out(points.size());
    kernels->single_precision.triangle_potential(frame, x.data(), y.data(), z.data(), static_cast<int>(out.size()),
                                                 out.data());
    for (std::size_t i = 0; i < out.size(); ++i) {
      EXPECT_NEAR(out[i] / greatest, TrianglePotential(points[i], a, b, c) / greatest, 3e-6)
          << kernels->name << " point " << i;
    }
  }
}

}  // namespace
}  // namespace geond
