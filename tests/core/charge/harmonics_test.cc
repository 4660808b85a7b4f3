// SPDX-License-Identifier: Apache-2.0
#include "core/charge/harmonics.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>
#include <Eigen/LU>

#include "core/charge/kernels.h"

namespace geond::charge {
namespace {

using Eigen::Vector3d;
constexpr int kOrder = 9;

Eigen::Map<const Eigen::VectorXd> AsVector(const std::vector<double>& values) {
  return {values.data(), static_cast<Eigen::Index>(values.size())};
}

struct Random {
  std::mt19937_64 engine{11};
  double operator()() { return static_cast<double>(engine() >> 11) * 0x1p-52 - 1.0; }
  Vector3d Vector() { return {(*this)(), (*this)(), (*this)()}; }
};

TEST(ShiftMatrix, MovesTheCentreOfTheHarmonics) {
  Random random;
  const Vector3d shift = random.Vector(), y = random.Vector();
  const std::vector<double> before = RegularHarmonics(y, kOrder), after = RegularHarmonics(0.5 * y + shift, kOrder);
  EXPECT_LT((ShiftMatrix(shift, 0.5, kOrder) * AsVector(before) - AsVector(after)).norm(), 1e-14);
}

TEST(MultipoleToLocalMatrix, GivesThePotentialToTheOrderOfTheExpansion) {
  Random random;
  double last = 1.0;
  for (int order : {4, 8, 12, 16}) {
    double largest = 0.0;
    for (int i = 0; i < 40; ++i) {
      const Vector3d source = 0.5 * random.Vector(), target = 0.5 * random.Vector(), distance(3.0, -2.0, 1.0);
      const double source_scale = i % 2 ? 0.5 : 1.0;
      const Eigen::VectorXd L =
          MultipoleToLocalMatrix(distance, source_scale, order, 2 * order) * AsVector(RegularHarmonics(source, order));
      const double potential = L.dot(AsVector(RegularHarmonics(target, order)));
      largest = std::max(largest, std::abs(potential * (distance + target - source_scale * source).norm() - 1.0));
    }
    EXPECT_LT(largest, 0.1 * last) << order;
    last = largest;
  }
  EXPECT_LT(last, 1e-7);
}

TEST(ReflectionSigns, LeaveOneMatrixForEightDistances) {
  const Vector3d distance(3.0, 2.0, 5.0);
  const Eigen::MatrixXd K = MultipoleToLocalMatrix(distance, 0.5, kOrder, 2 * kOrder);
  for (int axes = 0; axes < 8; ++axes) {
    const Vector3d reflected(axes & 1 ? -3.0 : 3.0, axes & 2 ? -2.0 : 2.0, axes & 4 ? -5.0 : 5.0);
    const std::vector<double> signs = ReflectionSigns(axes, kOrder);
    const auto S = AsVector(signs).asDiagonal();
    EXPECT_LT((MultipoleToLocalMatrix(reflected, 0.5, kOrder, 2 * kOrder) - S * K * S).norm(), 1e-13 * K.norm());
  }
}

TEST(Kernels, EvaluateHarmonicsAlikeInEveryInstructionSetAndPrecision) {
  constexpr int kPoints = 32;
  Random random;
  std::vector<double> x(kPoints), y(kPoints), z(kPoints);
  for (int i = 0; i < kPoints; ++i) x[i] = random(), y[i] = random(), z[i] = random();
  const auto check = [&](auto one, const Kernels& kernels, double tolerance) {
    using Real = decltype(one);
    const std::vector<Real> rx(x.begin(), x.end()), ry(y.begin(), y.end()), rz(z.begin(), z.end());
    std::vector<Real> U(kPoints * CoefficientCount(kOrder));
    LoopsOf<Real>(kernels).harmonics(kOrder, kPoints, rx.data(), ry.data(), rz.data(), U.data());
    for (int i = 0; i < kPoints; ++i) {
      const std::vector<double> expected = RegularHarmonics({x[i], y[i], z[i]}, kOrder);
      for (std::size_t j = 0; j < expected.size(); ++j) {
        EXPECT_NEAR(U[j * kPoints + i], expected[j], tolerance) << kernels.name << " point " << i << " harmonic " << j;
      }
    }
  };
  for (const Kernels* kernels : UsableKernels()) {
    check(1.0f, *kernels, 1e-6);
    check(1.0, *kernels, 1e-14);
  }
}

TEST(Kernels, MultiplyTranslateAndInvertAlikeInEveryInstructionSet) {
  Random random;
  constexpr int kRows = 37, kColumns = 21, kStride = 64, kVectors = 9, kLocal = 29, kOwn = 11;
  constexpr int kPairOrder = 5, kPairRows = Padded(CoefficientCount(kPairOrder));
  static_assert(kPairRows == 48);
  std::vector<double> A(kRows * kColumns + kPadding), x(kColumns), K(kStride * CoefficientCount(kPairOrder)),
      X(kVectors * kPairRows);
  for (auto* values : {&A, &x, &K, &X}) {
    for (double& value : *values) value = random();
  }
  // A degree and a degree that are together too high have nothing to do with each other.
  const auto degree = [](int place) { return static_cast<int>(std::sqrt(place + 0.5)); };
  for (int k = 0; k < CoefficientCount(kPairOrder); ++k) {
    for (int i = 0; i < kPairRows; ++i) {
      if (degree(i) + degree(k) > kPairOrder + kDegreesBeyond) K[k * kStride + i] = 0.0;
    }
  }
  Eigen::MatrixXf local = Eigen::MatrixXf::Identity(kLocal, kLocal) * 8.0f;
  for (float& value : local.reshaped()) value += static_cast<float>(random());
  const Eigen::MatrixXf inverse = local.inverse();
  for (const Kernels* kernels : UsableKernels()) {
    std::vector<double> y(kRows, 0.5), Y(kVectors * kPairRows, 0.25);
    kernels->double_precision.multiply(A.data(), kRows, kColumns, x.data(), y.data());
    for (int i = 0; i < kRows; ++i) {
      double expected = 0.5;
      for (int k = 0; k < kColumns; ++k) expected += A[k * kRows + i] * x[k];
      EXPECT_NEAR(y[i], expected, 1e-13) << kernels->name;
    }
    std::vector<CellPair> pairs;
    std::vector<double> plus(kPairRows, 1.0), minus(kPairRows, -1.0);
    minus[3] = 1.0;
    const double* const signs[8] = {plus.data(), minus.data()};
    for (int v = 0; v < kVectors; ++v)
      pairs.push_back({(v + 4) % kVectors * kPairRows / kPadding, v * kPairRows / kPadding, v % 2});
    kernels->double_precision.translate_pairs(K.data(), kPairOrder, kStride, pairs.data(), kVectors, signs, X.data(),
                                              Y.data());
    kernels->double_precision.translate(K.data(), kColumns, 32, kStride, X.data(), Y.data());
    for (int v = 0; v < kVectors; ++v) {
      const int target = (v + 4) % kVectors;
      for (int i = 0; i < kPairRows; ++i) {
        double expected = 0.25;
        for (int k = 0; k < CoefficientCount(kPairOrder); ++k) {
          expected += signs[v % 2][i] * K[k * kStride + i] * signs[v % 2][k] * X[v * kPairRows + k];
          if (target == 0 && i < 32 && k < kColumns) expected += K[k * kStride + i] * X[k];
        }
        EXPECT_NEAR(Y[target * kPairRows + i], expected, 1e-13) << kernels->name;
      }
    }
    const int width = Padded(kLocal + kOwn);
    std::vector<float> M(kLocal * width, 0.0f), rows(kLocal * kOwn);
    for (int i = 0; i < kLocal; ++i) {
      for (int k = 0; k < kLocal; ++k) M[k * width + i] = local(i, k);
      if (i >= kLocal - kOwn) M[i * width + kLocal + i - (kLocal - kOwn)] = 1.0f;
    }
    EXPECT_TRUE(kernels->inverse_rows(M.data(), kLocal, kOwn, width, rows.data()));
    for (int a = 0; a < kOwn; ++a) {
      for (int j = 0; j < kLocal; ++j)
        EXPECT_NEAR(rows[j * kOwn + a], inverse(kLocal - kOwn + a, j), 1e-5) << kernels->name;
    }
  }
}

}  // namespace
}  // namespace geond::charge
