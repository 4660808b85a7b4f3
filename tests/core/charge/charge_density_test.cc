// SPDX-License-Identifier: Apache-2.0
#include "core/charge/charge_density.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <numeric>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/base/error.h"
#include "core/charge/dense.h"
#include "core/charge/panels.h"
#include "core/charge/potential.h"
#include "tests/core/charge/shapes.h"

namespace geond {
namespace {

using Eigen::Vector3d;
using testing::HasSubstr;

ChargeOptions Exact() {
  ChargeOptions options;
  options.solver = ChargeOptions::Solver::kDense;
  return options;
}

TriangleMesh Vase() {
  TriangleMesh mesh = shapes::Torus(2.0, 0.7, 24, 12);
  for (Vector3d& v : mesh.vertices) v.z() += 0.3 * v.x() * v.x() + 0.2 * v.y();
  return mesh;
}

double Charge(const TriangleMesh& mesh, const ChargeDensity& charge) {
  const std::vector<double> areas = TriangleAreas(mesh);
  return std::inner_product(areas.begin(), areas.end(), charge.density.begin(), 0.0);
}

std::vector<double> ExactEllipsoid(const TriangleMesh& mesh, double a, double b, double c) {
  std::vector<double> density;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    // The flat triangle lies a little inside: take the surface point in its direction.
    Vector3d p = TriangleCentroid(mesh, static_cast<int>(i));
    p /= p.cwiseQuotient(Vector3d(a, b, c)).norm();
    density.push_back(shapes::EllipsoidDensity(p, a, b, c));
  }
  return density;
}

TEST(SolveChargeDensity, AgreesWithAnIndependentDenseSolve) {
  std::ifstream file(GEOND_TEST_DATA "/charge.json");
  ASSERT_TRUE(file);
  for (const auto& shape : nlohmann::json::parse(file)) {
    TriangleMesh mesh;
    for (const auto& v : shape["vertices"])
      mesh.vertices.emplace_back(v[0].get<double>(), v[1].get<double>(), v[2].get<double>());
    for (const auto& f : shape["faces"]) mesh.triangles.push_back(f.get<TriangleMesh::Triangle>());
    const ChargeDensity charge = SolveChargeDensity(mesh, Exact());
    const double Q = shape["Q"];
    EXPECT_NEAR(charge.potential * Q / shape["V"].get<double>(), 1.0, 1e-11) << shape["name"];
    for (std::size_t i = 0; i < charge.density.size(); ++i) {
      EXPECT_NEAR(charge.density[i] * Q / shape["rho"][i].get<double>(), 1.0, 1e-9) << shape["name"] << ' ' << i;
    }
  }
}

TEST(SolveChargeDensity, CarriesUnitChargeAndTheSamePotentialAtEveryCentroid) {
  const TriangleMesh mesh = Vase();
  const ChargeDensity charge = SolveChargeDensity(mesh, Exact());
  EXPECT_TRUE(charge.summary.converged) << charge.summary.message;
  EXPECT_NEAR(Charge(mesh, charge), 1.0, 1e-13);
  EXPECT_NEAR(charge.capacitance * charge.potential, 1.0, 1e-14);
  for (int i = 0; i < static_cast<int>(mesh.triangles.size()); i += 37) {
    double potential = 0.0;
    for (std::size_t k = 0; k < mesh.triangles.size(); ++k) {
      const auto& [a, b, c] = mesh.triangles[k];
      potential += charge.density[k] *
                   TrianglePotential(TriangleCentroid(mesh, i), mesh.vertices[a], mesh.vertices[b], mesh.vertices[c]);
    }
    EXPECT_NEAR(potential, charge.potential, 1e-11 * charge.potential);
  }
}

TEST(SolveChargeDensity, ScalesAsChargeOverAreaAndMovesWithTheBody) {
  const TriangleMesh mesh = Vase();
  const ChargeDensity charge = SolveChargeDensity(mesh, Exact());
  TriangleMesh moved = mesh;
  const Eigen::AngleAxisd turn(1.1, Vector3d(1, 2, -1).normalized());
  for (Vector3d& v : moved.vertices) v = 1e-3 * (turn * v) + Vector3d(0.1, -0.2, 0.3);
  const ChargeDensity small = SolveChargeDensity(moved, Exact());
  EXPECT_NEAR(small.capacitance, 1e-3 * charge.capacitance, 1e-14);
  for (std::size_t i = 0; i < charge.density.size(); ++i) {
    EXPECT_NEAR(small.density[i] / charge.density[i], 1e6, 1e-3);
  }
}

TEST(SolveChargeDensity, FollowsTheOrderOfTheTriangles) {
  const TriangleMesh mesh = Vase();
  TriangleMesh reversed = mesh;
  std::reverse(reversed.triangles.begin(), reversed.triangles.end());
  std::vector<double> density = SolveChargeDensity(reversed, Exact()).density;
  std::reverse(density.begin(), density.end());
  const std::vector<double> expected = SolveChargeDensity(mesh, Exact()).density;
  for (std::size_t i = 0; i < density.size(); ++i) EXPECT_NEAR(density[i] / expected[i], 1.0, 1e-10);
}

TEST(SolveChargeDensity, OfASphereIsEvenAndOfEllipsoidsTheClosedForm) {
  // Measured errors of centroid collocation on such meshes: 2.2 and 0.64 % on the sphere, 2.4 and 0.69 % at 1:2:3, 2.8
  // and 1.0 % at 1:1:5; the potential 1.3 and 0.33 % high.
  struct Case {
    double a, b, c, rms[2];
  };
  for (const Case& e :
       {Case{1, 1, 1, {0.022, 0.0064}}, Case{1, 2, 3, {0.024, 0.0069}}, Case{1, 1, 5, {0.028, 0.010}}}) {
    for (int level : {2, 3}) {
      const TriangleMesh mesh = shapes::Ellipsoid(level, e.a, e.b, e.c);
      const ChargeDensity charge = SolveChargeDensity(mesh, Exact());
      EXPECT_LT(shapes::RelativeRms(mesh, charge.density, ExactEllipsoid(mesh, e.a, e.b, e.c)), 1.05 * e.rms[level - 2])
          << e.a << ':' << e.b << ':' << e.c;
      const double high = charge.potential * shapes::EllipsoidCapacitance(e.a, e.b, e.c) - 1.0;
      EXPECT_GT(high, 0.0);
      EXPECT_LT(high, level == 2 ? 0.017 : 0.0043);
      EXPECT_GT(*std::min_element(charge.density.begin(), charge.density.end()), 0.0);
    }
  }
}

TEST(SolveChargeDensity, GrowsAtEdgesAndCornersOfACube) {
  const TriangleMesh mesh = shapes::Cube(12);
  const ChargeDensity charge = SolveChargeDensity(mesh, Exact());
  EXPECT_NEAR(charge.capacitance, 0.66067815, 0.003);
  const auto [least, most] = std::minmax_element(charge.density.begin(), charge.density.end());
  const auto distance_to_centre = [&](auto at) {
    return (TriangleCentroid(mesh, static_cast<int>(at - charge.density.begin())) - Vector3d(0.5, 0.5, 0.5)).norm();
  };
  EXPECT_LT(distance_to_centre(least), 0.52);
  EXPECT_GT(distance_to_centre(most), 0.8);
}

TEST(SolveChargeDensity, GathersNoChargeInsideAClosedShell) {
  TriangleMesh inner = shapes::Sphere(1);
  for (Vector3d& v : inner.vertices) v *= 0.5;
  const TriangleMesh outer = shapes::Sphere(2);
  const ChargeDensity charge = SolveChargeDensity(shapes::Merged(outer, inner), Exact());
  for (std::size_t i = outer.triangles.size(); i < charge.density.size(); ++i) {
    EXPECT_LT(std::abs(charge.density[i]), 1e-2 * charge.density[0]);
  }
}

TEST(SolveChargeDensity, ComesOutOfLuAndGmresAlike) {
  const TriangleMesh mesh = Vase();
  const charge::Panels panels = charge::MakePanels(mesh);
  const auto solve = [&](charge::DenseMethod method) { return charge::SolveDense(mesh, panels, method, 0, {}, {}); };
  const auto gmres = solve(charge::DenseMethod::kGmres), lu = solve(charge::DenseMethod::kLu);
  EXPECT_GT(gmres.summary.iterations, 0);
  EXPECT_EQ(lu.summary.iterations, 0);
  EXPECT_TRUE(lu.summary.converged);
  for (std::size_t i = 0; i < panels.size(); ++i) EXPECT_NEAR(gmres.x[i] / lu.x[i], 1.0, 1e-10);
}

TEST(SolveChargeDensity, GivesTheSameBitsOnAnyNumberOfThreads) {
  const TriangleMesh mesh = shapes::Sphere(3);
  ChargeOptions options = Exact();
  options.threads = 1;
  const std::vector<double> expected = SolveChargeDensity(mesh, options).density;
  for (int threads : {2, 3, 8}) {
    options.threads = threads;
    EXPECT_TRUE(SolveChargeDensity(mesh, options).density == expected) << threads;
  }
}

ChargeOptions Fast(double tolerance) {
  ChargeOptions options;
  options.solver = ChargeOptions::Solver::kFast;
  options.tolerance = tolerance;
  return options;
}

// Root mean square and largest difference of two densities, relative to their mean over the area.
std::pair<double, double> Difference(const TriangleMesh& mesh, const ChargeDensity& a, const ChargeDensity& b) {
  const std::vector<double> areas = TriangleAreas(mesh);
  const double area = std::accumulate(areas.begin(), areas.end(), 0.0);
  double squares = 0.0, largest = 0.0;
  for (std::size_t i = 0; i < areas.size(); ++i) {
    const double difference = (a.density[i] - b.density[i]) * area;  // the mean is 1 / area
    squares += areas[i] / area * difference * difference;
    largest = std::max(largest, std::abs(difference));
  }
  return {std::sqrt(squares), largest};
}

TEST(SolveChargeDensity, FastDiffersFromExactByLessThanTheTolerance) {
  for (const TriangleMesh& mesh : {shapes::Sphere(3), shapes::Cube(14), shapes::Cube(12, 3.0), shapes::Peanut(16),
                                   Vase(), shapes::Merged(shapes::Sphere(2), shapes::Ellipsoid(2, 0.2, 0.3, 0.4))}) {
    const ChargeDensity exact = SolveChargeDensity(mesh, Exact());
    const ChargeDensity fast = SolveChargeDensity(mesh, Fast(5e-4));
    EXPECT_EQ(fast.solver, ChargeOptions::Solver::kFast);
    EXPECT_TRUE(fast.summary.converged) << fast.summary.message;
    EXPECT_NEAR(Charge(mesh, fast), 1.0, 1e-12);
    const auto [rms, largest] = Difference(mesh, fast, exact);
    EXPECT_LT(rms, 5e-4) << mesh.triangles.size();
    EXPECT_LT(largest, 5e-3) << mesh.triangles.size();
    EXPECT_GT(fast.error_estimate, 0.0);
    EXPECT_LE(fast.error_estimate, 5e-4);
    EXPECT_GT(fast.near_pairs, mesh.triangles.size());
    EXPECT_GT(fast.seconds.near, 0.0);
    EXPECT_GT(fast.seconds.products, 0.0);
  }
}

// The charges on two faces that all but touch depend on the small difference of potentials over the gap.
TEST(SolveChargeDensity, FastFindsThinGapsAndSolvesThemInDoublePrecision) {
  for (double gap : {0.05, 1e-4, 1e-5}) {
    TriangleMesh upper = shapes::Cube(8);
    for (Eigen::Vector3d& v : upper.vertices) v.z() += 1.0 + gap;
    const TriangleMesh mesh = shapes::Merged(shapes::Cube(8), upper);
    const ChargeDensity fast = SolveChargeDensity(mesh, Fast(5e-4));
    const auto [rms, largest] = Difference(mesh, fast, SolveChargeDensity(mesh, Exact()));
    EXPECT_LT(rms, 5e-4) << gap;
    EXPECT_LT(largest, 5e-3) << gap;
    EXPECT_EQ(fast.summary.message.find("double precision") != std::string::npos, gap < 0.001) << fast.summary.message;
  }
}

TEST(SolveChargeDensity, FastComesWithinAMillionthWhenAsked) {
  for (const TriangleMesh& mesh : {shapes::Sphere(3), shapes::Cube(10, 2.0)}) {
    const auto [rms, largest] =
        Difference(mesh, SolveChargeDensity(mesh, Fast(1e-6)), SolveChargeDensity(mesh, Exact()));
    EXPECT_LT(rms, 1e-6) << mesh.triangles.size();
    EXPECT_LT(largest, 1e-5) << mesh.triangles.size();
  }
}

TEST(SolveChargeDensity, FastGivesTheSameBitsOnAnyNumberOfThreads) {
  const TriangleMesh mesh = shapes::Sphere(4);
  ChargeOptions options = Fast(1e-3);
  options.threads = 1;
  const std::vector<double> expected = SolveChargeDensity(mesh, options).density;
  for (int threads : {2, 5}) {
    options.threads = threads;
    EXPECT_TRUE(SolveChargeDensity(mesh, options).density == expected) << threads;
  }
}

TEST(SolveChargeDensity, ChoosesTheSolverByItselfAndSaysWhatAnOtherCannotDo) {
  EXPECT_EQ(SolveChargeDensity(shapes::Sphere(2)).solver, ChargeOptions::Solver::kDense);
  EXPECT_EQ(SolveChargeDensity(shapes::Sphere(3)).solver, ChargeOptions::Solver::kFast);
  EXPECT_THROW(SolveChargeDensity(shapes::Sphere(2), Fast(1e-8)), std::invalid_argument);
  EXPECT_THROW(SolveChargeDensity(shapes::Cube(71), Exact()), std::invalid_argument);
}

TEST(SolveChargeDensity, HasOneSignWhenAsked) {
  // A slab stands on a plate: in the corners between them collocation on uneven triangles overshoots.
  TriangleMesh mesh = shapes::Cube(9);
  TriangleMesh plate = shapes::Cube(7, 1.7);
  for (Vector3d& v : plate.vertices) v = Vector3d(4.0 * v.x() - 1.6, 4.0 * v.y() - 1.7, 0.2 * v.z() - 0.2005);
  mesh = shapes::Merged(mesh, plate);
  ChargeOptions one_sign = Exact();
  one_sign.one_sign = true;
  const ChargeDensity plain = SolveChargeDensity(mesh, Exact()), charge = SolveChargeDensity(mesh, one_sign);
  ASSERT_GT(plain.negative, 0u);
  EXPECT_EQ(charge.negative, plain.negative);
  EXPECT_LT(*std::min_element(plain.density.begin(), plain.density.end()), 0.0);
  EXPECT_GE(*std::min_element(charge.density.begin(), charge.density.end()), 0.0);
  EXPECT_NEAR(Charge(mesh, charge), 1.0, 1e-12);
  EXPECT_EQ(charge.capacitance, plain.capacitance);
  const auto [rms, largest] = Difference(mesh, charge, plain);
  EXPECT_LT(rms, 0.1);
}

TEST(SolveChargeDensity, SolvesOpenSheetsAndEdgesOfThreeTriangles) {
  TriangleMesh fins;
  fins.vertices = {{0, 0, 0}, {0, 0, 1}, {1, 0, 0}, {0, 1, 0}, {-1, -1, 0}};
  fins.triangles = {{0, 1, 2}, {0, 1, 3}, {0, 1, 4}};
  const ChargeDensity charge = SolveChargeDensity(fins, Exact());
  EXPECT_TRUE(charge.summary.converged);
  for (double density : charge.density) EXPECT_GT(density, 0.0);
}

TriangleMesh Moved(TriangleMesh mesh, const Vector3d& by) {
  for (Vector3d& v : mesh.vertices) v += by;
  return mesh;
}

// Every solver comes to an end with finite numbers whose charge is one.
TEST(SolveChargeDensity, SolvesMeshesThatAreNoProperSurface) {
  TriangleMesh open = shapes::Cube(6);
  open.triangles.resize(open.triangles.size() / 2);
  TriangleMesh fins = shapes::Sphere(2);
  fins.vertices.emplace_back(2.0, 0.0, 0.0);
  const int apex = static_cast<int>(fins.vertices.size()) - 1;
  for (int t = 0; t < 20; ++t)
    fins.triangles.push_back({fins.triangles[t][0], fins.triangles[t][1], apex});  // three at an edge
  TriangleMesh inverted = shapes::Sphere(2);
  for (auto& t : inverted.triangles) std::swap(t[0], t[1]);
  TriangleMesh needle = shapes::Sphere(2);
  needle.vertices.insert(needle.vertices.end(), {{3, 0, 0}, {4, 0, 0}, {3.5, 1e-5, 0}});
  const int n = static_cast<int>(needle.vertices.size());
  needle.triangles.push_back({n - 3, n - 2, n - 1});
  const std::pair<const char*, TriangleMesh> meshes[] = {
      {"open", open},
      {"three triangles at an edge", fins},
      {"inside out", inverted},
      {"a needle", needle},
      {"two shells apart", shapes::Merged(shapes::Sphere(2), Moved(shapes::Sphere(2), {5, 0, 0}))},
      {"one shell in another", shapes::Merged(shapes::Sphere(2), shapes::Ellipsoid(2, 0.5, 0.4, 0.3))},
      {"shells that cross", shapes::Merged(shapes::Sphere(2), Moved(shapes::Cube(6), {0.2, 0.1, 0.3}))},
      {"cubes that touch in a corner", shapes::Merged(shapes::Cube(6), Moved(shapes::Cube(6), {1, 1, 1}))},
      {"cubes that touch in an edge", shapes::Merged(shapes::Cube(6), Moved(shapes::Cube(6), {1, 1, 0.1}))},
      {"cubes that share part of a face", shapes::Merged(shapes::Cube(6), Moved(shapes::Cube(6), {1, 0.31, 0.23}))},
      {"a sheet over another", shapes::Merged(open, Moved(open, {0, 0, 0.02}))},
  };
  for (const auto& [name, mesh] : meshes) {
    for (ChargeOptions options : {Exact(), Fast(5e-4)}) {
      options.one_sign = true;
      const ChargeDensity charge = SolveChargeDensity(mesh, options);
      EXPECT_TRUE(std::isfinite(charge.capacitance) && charge.capacitance > 0.0) << name;
      for (double density : charge.density) ASSERT_TRUE(std::isfinite(density) && density >= 0.0) << name;
      EXPECT_NEAR(Charge(mesh, charge), 1.0, 1e-9) << name;
      EXPECT_TRUE(charge.summary.converged) << name << ": " << charge.summary.message;
    }
  }
}

std::string Refusal(const TriangleMesh& mesh) {
  try {
    SolveChargeDensity(mesh);
  } catch (const std::invalid_argument& refused) {
    return refused.what();
  }
  return "not refused";
}

TEST(SolveChargeDensity, RefusesWhatHasNoAnswerAndNamesTheTriangle) {
  EXPECT_THAT(Refusal({}), HasSubstr("no triangles"));
  TriangleMesh flat = shapes::Sphere(0);
  flat.vertices.push_back(0.5 * (flat.vertices[0] + flat.vertices[11]));
  flat.triangles.push_back({0, 11, 12});
  EXPECT_THAT(Refusal(flat), HasSubstr("triangle 20 has no area"));
  TriangleMesh twice = shapes::Sphere(0);
  twice.triangles.push_back({twice.triangles[3][1], twice.triangles[3][0], twice.triangles[3][2]});
  EXPECT_THAT(Refusal(twice), HasSubstr("triangles 3 and 20 have the same centroid"));
  TriangleMesh broken = shapes::Sphere(0);
  broken.vertices[5].y() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(Refusal(broken), HasSubstr("not finite"));
  TriangleMesh wild = shapes::Sphere(0);
  wild.triangles[7][2] = 99;
  EXPECT_THAT(Refusal(wild), HasSubstr("triangle 7"));
  ChargeOptions options;
  options.tolerance = 0.0;
  EXPECT_THROW(SolveChargeDensity(shapes::Sphere(0), options), std::invalid_argument);
}

TEST(SolveChargeDensity, ReportsProgressAndStopsWhenAsked) {
  std::stop_source source;
  int calls = 0;
  const StepObserver stop_soon = [&](std::string_view step, int, int) {
    EXPECT_THAT(std::string(step), HasSubstr("charge"));
    if (++calls == 2) source.request_stop();
  };
  EXPECT_THROW(SolveChargeDensity(shapes::Sphere(3), Exact(), source.get_token(), stop_soon), Cancelled);
  EXPECT_EQ(calls, 2);
}

}  // namespace
}  // namespace geond
