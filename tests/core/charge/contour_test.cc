// SPDX-License-Identifier: Apache-2.0
#include "core/charge/contour.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <stdexcept>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace geond {
namespace {

using Eigen::Vector2d;
using Complex = std::complex<double>;
constexpr double kPi = std::numbers::pi;

// The image of n points of the unit circle under an exterior conformal map f, and the exact density 1/(2 pi |f'|) there
// for unit charge.
struct Mapped {
  std::vector<Vector2d> polygon;
  std::vector<double> exact;
};

template <typename Map, typename Slope>
Mapped MapCircle(int n, const Map& f, const Slope& slope) {
  Mapped mapped;
  for (int i = 0; i < n; ++i) {
    const Complex w = std::polar(1.0, 2.0 * kPi * i / n);
    mapped.polygon.emplace_back(f(w).real(), f(w).imag());
    mapped.exact.push_back(1.0 / (2.0 * kPi * std::abs(slope(w))));
  }
  return mapped;
}

Mapped Ellipse(int n, double a, double b) {
  return MapCircle(n, [=](Complex w) { return 0.5 * (a + b) * w + 0.5 * (a - b) / w; },
                   [=](Complex w) { return 0.5 * (a + b) - 0.5 * (a - b) / (w * w); });
}

// c = 1 has `cusps` cusps; c < 0 is dented instead.
Mapped Hypocycloid(int n, int cusps, double c) {
  return MapCircle(n, [=](Complex w) { return w + c / (cusps - 1.0) * std::pow(w, 1 - cusps); },
                   [=](Complex w) { return 1.0 - c * std::pow(w, -cusps); });
}

double LargestError(const Mapped& mapped, const ContourDensity& charge) {
  double largest = 0.0;
  for (std::size_t i = 0; i < mapped.exact.size(); ++i) {
    largest = std::max(largest, std::abs(charge.density[i] / mapped.exact[i] - 1.0));
  }
  return largest;
}

double Total(std::span<const Vector2d> polygon, const ContourDensity& charge) {
  double total = 0.0;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    total += charge.segment_density[i] * (polygon[(i + 1) % polygon.size()] - polygon[i]).norm();
  }
  return total;
}

TEST(SolveContourCharge, OfARegularPolygonIsEven) {
  const Mapped circle = Ellipse(100, 3, 3);
  const ContourDensity charge = SolveContourCharge(circle.polygon);
  EXPECT_TRUE(charge.summary.converged);
  EXPECT_NEAR(Total(circle.polygon, charge), 1.0, 1e-12);
  const auto [least, most] = std::minmax_element(charge.density.begin(), charge.density.end());
  EXPECT_NEAR(*least / *most, 1.0, 1e-9);
  EXPECT_NEAR(charge.potential, -2.0 * std::log(3.0), 2e-3);  // the capacity of a circle is its radius
}

TEST(SolveContourCharge, OfAnEllipseIsTheClosedForm) {
  for (const auto& [ratio, bar] : {std::pair{2.0, 7.5e-4}, {3.0, 4.0e-3}, {5.0, 2.9e-2}}) {
    const Mapped ellipse = Ellipse(360, ratio, 1.0);
    EXPECT_LT(LargestError(ellipse, SolveContourCharge(ellipse.polygon)), bar) << ratio;
  }
}

TEST(SolveContourCharge, OfHypocycloidsIsThatOfTheirConformalMap) {
  const Mapped four = Hypocycloid(1000, 4, 0.8), three = Hypocycloid(1000, 3, 0.9), dented = Hypocycloid(1000, 5, -0.7);
  EXPECT_LT(LargestError(four, SolveContourCharge(four.polygon)), 5e-3);
  EXPECT_LT(LargestError(three, SolveContourCharge(three.polygon)), 2e-2);
  EXPECT_LT(LargestError(dented, SolveContourCharge(dented.polygon)), 5e-3);
}

// The cardioid r = (1 + cos t)/2. Its outside is the inverse of the inside of a parabola about the focus, and that the square
// of the strip |Re s| < 1: with s = 1 + i tan(t/2) on the edge the density is sech(pi Im s/2) |s|^3/4, none at the cusp.
TEST(SolveContourCharge, OfACardioidIsThatOfItsConformalMap) {
  constexpr int kCount = 1500;
  Mapped cardioid;
  for (int i = 0; i < kCount; ++i) {
    const double t = 2.0 * kPi * (i + 0.5) / kCount - kPi, r = 0.5 * (1.0 + std::cos(t)), v = std::tan(0.5 * t);
    cardioid.polygon.emplace_back(r * std::cos(t), r * std::sin(t));
    cardioid.exact.push_back(0.25 / std::cosh(0.5 * kPi * v) * std::pow(1.0 + v * v, 1.5));
  }
  const ContourDensity charge = SolveContourCharge(cardioid.polygon);
  EXPECT_TRUE(charge.summary.converged) << charge.summary.message;
  double largest = 0.0;
  // In the cusp the two sides are closer than the segments are long.
  for (int i = kCount / 10; i < kCount - kCount / 10; ++i) {
    largest = std::max(largest, std::abs(charge.density[i] - cardioid.exact[i]));
  }
  EXPECT_LT(largest, 2e-3);
}

// Staircases, as the outlines of pixels are, with a dent that comes close to itself.
std::vector<Vector2d> PixelOutline(int size) {
  std::vector<Vector2d> outline;
  const int n = 4 * size;
  Vector2d last(1e9, 1e9);
  for (int i = 0; i < 40 * n; ++i) {
    const double t = 2.0 * kPi * i / (40.0 * n), r = size * (1.0 + 0.3 * std::cos(5.0 * t));
    const Vector2d p(std::round(r * std::cos(t)), std::round(0.7 * r * std::sin(t)));
    if (p != last) outline.push_back(p);
    last = p;
  }
  if (outline.front() == outline.back()) outline.pop_back();
  return outline;
}

TEST(SolveContourCharge, ByMultipolesIsThatOfTheWholeMatrix) {
  const Mapped smooth = Hypocycloid(900, 4, 0.8);
  for (const std::vector<Vector2d>& polygon : {smooth.polygon, PixelOutline(150)}) {
    ASSERT_GT(polygon.size(), 700u);
    ContourOptions whole, fast;
    whole.solver = ContourOptions::Solver::kDense;
    fast.solver = ContourOptions::Solver::kFast;
    const ContourDensity exact = SolveContourCharge(polygon, whole), charge = SolveContourCharge(polygon, fast);
    EXPECT_TRUE(charge.summary.converged) << charge.summary.message;
    EXPECT_NEAR(Total(polygon, charge), 1.0, 1e-12);
    EXPECT_NEAR(charge.potential, exact.potential, 1e-6);
    double squares = 0.0;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
      const double length = (polygon[(i + 1) % polygon.size()] - polygon[i]).norm();
      squares += std::pow((charge.segment_density[i] - exact.segment_density[i]) * length, 2);
    }
    EXPECT_LT(std::sqrt(squares * static_cast<double>(polygon.size())), fast.tolerance) << polygon.size();
    EXPECT_LE(charge.error_estimate, fast.tolerance);
  }
}

TEST(SolveContourCharge, GivesTheSameBitsOnAnyNumberOfThreads) {
  const Mapped shape = Ellipse(1500, 3, 1);
  ContourOptions options;
  options.threads = 1;
  const std::vector<double> expected = SolveContourCharge(shape.polygon, options).density;
  options.threads = 3;
  EXPECT_TRUE(SolveContourCharge(shape.polygon, options).density == expected);
}

TEST(SolveContourCharge, TakesAContourThatRepeatsItsFirstVertexAtTheEnd) {
  Mapped shape = Hypocycloid(200, 3, 0.6);
  const std::vector<double> expected = SolveContourCharge(shape.polygon).density;
  shape.polygon.push_back(shape.polygon.front());
  EXPECT_TRUE(SolveContourCharge(shape.polygon).density == expected);
}

TEST(SolveContourCharge, ScalesMovesAndTurnsRoundWithTheContour) {
  const Mapped shape = Hypocycloid(200, 3, 0.6);
  const ContourDensity charge = SolveContourCharge(shape.polygon);
  std::vector<Vector2d> moved;
  for (const Vector2d& p : shape.polygon) moved.push_back(1e-3 * Vector2d(p.y(), -p.x()) + Vector2d(5, 7));
  std::reverse(moved.begin(), moved.end());
  const ContourDensity other = SolveContourCharge(moved);
  const std::size_t n = moved.size();
  for (std::size_t i = 0; i < n; ++i) EXPECT_NEAR(1e-3 * other.density[n - 1 - i] / charge.density[i], 1.0, 1e-6);
  EXPECT_NEAR(other.potential, charge.potential - 2.0 * std::log(1e-3), 1e-6);
}

TEST(SolveContourCharge, DoesNotBreakDownWhereTheCapacityIsOne) {
  const Mapped circle = Ellipse(64, 1, 1);
  const ContourDensity charge = SolveContourCharge(circle.polygon);
  for (double density : charge.density) EXPECT_NEAR(density * 2.0 * kPi, 1.0, 2e-3);
  EXPECT_NEAR(charge.potential, 0.0, 2e-3);
}

TEST(SolveContourCharge, RefusesWhatIsNoContourAndNamesTheVertex) {
  const auto refusal = [](std::vector<Vector2d> polygon) -> std::string {
    try {
      SolveContourCharge(polygon);
    } catch (const std::invalid_argument& refused) {
      return refused.what();
    }
    return "not refused";
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(refusal({{0, 0}, {1, 0}}), testing::HasSubstr("three vertices"));
  EXPECT_THAT(refusal({{0, 0}, {1, 0}, {nan, 1}}), testing::HasSubstr("vertex 2"));
  EXPECT_THAT(refusal({{0, 0}, {1, 0}, {1, 0}, {0, 1}}), testing::HasSubstr("vertex 2"));
  EXPECT_THAT(refusal({{0, 0}, {1, 0}, {0, 0}}), testing::HasSubstr("three vertices"));
}

}  // namespace
}  // namespace geond
