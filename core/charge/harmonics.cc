// SPDX-License-Identifier: Apache-2.0
#include "core/charge/harmonics.h"

#include <algorithm>
#include <cmath>
#include <complex>

namespace geond::charge {
namespace {

using Complex = std::complex<double>;

double AlternatingSign(int m) { return m % 2 == 0 ? 1.0 : -1.0; }

// F_n^m for 0 <= m <= n <= order; the others by symmetry.
class HarmonicTable {
 public:
  explicit HarmonicTable(int order) : values_((order + 1) * (order + 2) / 2) {}
  Complex& at(int n, int m) { return values_[n * (n + 1) / 2 + m]; }
  Complex operator()(int n, int m) const {
    if (std::abs(m) > n) return 0.0;
    const Complex value = values_[n * (n + 1) / 2 + std::abs(m)];
    return m >= 0 ? value : AlternatingSign(m) * std::conj(value);
  }

 private:
  std::vector<Complex> values_;
};

HarmonicTable Regular(const Eigen::Vector3d& y, int order) {
  HarmonicTable U(order);
  const Complex across(y.x(), y.y());
  const double r2 = y.squaredNorm();
  U.at(0, 0) = 1.0;
  for (int m = 0; m <= order; ++m) {
    if (m > 0) U.at(m, m) = -across / (2.0 * m) * U(m - 1, m - 1);
    for (int n = m + 1; n <= order; ++n) {
      U.at(n, m) = ((2.0 * n - 1.0) * y.z() * U(n - 1, m) - r2 * U(n - 2, m)) / static_cast<double>(n * n - m * m);
    }
  }
  return U;
}

HarmonicTable Irregular(const Eigen::Vector3d& x, int order) {
  HarmonicTable V(order);
  const Complex across(x.x(), x.y());
  const double r2 = x.squaredNorm();
  V.at(0, 0) = 1.0 / std::sqrt(r2);
  for (int m = 0; m <= order; ++m) {
    if (m > 0) V.at(m, m) = -(2.0 * m - 1.0) * across / r2 * V(m - 1, m - 1);
    for (int n = m + 1; n <= order; ++n) {
      const double below = static_cast<double>((n - 1) * (n - 1) - m * m);
      V.at(n, m) = ((2.0 * n - 1.0) * x.z() * V(n - 1, m) - below * V(n - 2, m)) / r2;
    }
  }
  return V;
}

// Calls body(n, m) for 0 <= m <= n <= order.
template <typename Body>
void ForEachDegree(int order, const Body& body) {
  for (int n = 0; n <= order; ++n) {
    for (int m = 0; m <= n; ++m) body(n, m);
  }
}

// Writes the column of a map from one real coefficient to a complex harmonic of (n, m) as its real and imaginary rows.
void SetRows(Eigen::MatrixXd& matrix, int n, int m, int column, Complex value) {
  matrix(CoefficientIndex(n, m, false), column) = value.real();
  if (m > 0) matrix(CoefficientIndex(n, m, true), column) = value.imag();
}

}  // namespace

std::vector<double> RegularHarmonics(const Eigen::Vector3d& y, int order) {
  const HarmonicTable U = Regular(y, order);
  std::vector<double> values(CoefficientCount(order));
  ForEachDegree(order, [&](int n, int m) {
    values[CoefficientIndex(n, m, false)] = U(n, m).real();
    if (m > 0) values[CoefficientIndex(n, m, true)] = U(n, m).imag();
  });
  return values;
}

Eigen::MatrixXd ShiftMatrix(const Eigen::Vector3d& shift, double scale, int order) {
  const int count = CoefficientCount(order);
  const HarmonicTable U = Regular(shift, order);
  Eigen::MatrixXd T = Eigen::MatrixXd::Zero(count, count);
  ForEachDegree(order, [&](int n, int m) {
    ForEachDegree(n, [&](int k, int l) {
      const double size = std::pow(scale, k);
      const Complex plus = size * U(n - k, m - l), minus = size * AlternatingSign(l) * U(n - k, m + l);
      SetRows(T, n, m, CoefficientIndex(k, l, false), l == 0 ? plus : plus + minus);
      if (l > 0) SetRows(T, n, m, CoefficientIndex(k, l, true), Complex(0, 1) * (plus - minus));
    });
  });
  return T;
}

Eigen::MatrixXd MultipoleToLocalMatrix(const Eigen::Vector3d& distance, double source_scale, int order,
                                       int most_degrees) {
  const int count = CoefficientCount(order), most = std::min(2 * order, most_degrees), width = 2 * most + 1;
  const HarmonicTable half = Irregular(distance, most);
  std::vector<Complex> V(static_cast<std::size_t>(most + 1) * width);  // V_n^m at n * width + most + m
  for (int n = 0; n <= most; ++n) {
    for (int m = -n; m <= n; ++m) V[n * width + most + m] = half(n, m);
  }
  std::vector<double> scales(order + 1, 1.0);
  for (int n = 1; n <= order; ++n) scales[n] = source_scale * scales[n - 1];
  Eigen::MatrixXd K = Eigen::MatrixXd::Zero(count, count);
  ForEachDegree(order, [&](int k, int l) {
    const double weight = AlternatingSign(k) * (l == 0 ? 1.0 : 2.0);  // -l gives the same again
    ForEachDegree(std::min(order, most - k), [&](int n, int m) {
      const double size = weight * scales[n];
      const Complex* const centre = &V[(n + k) * width + most + l];
      const Complex plus = size * centre[m], minus = size * AlternatingSign(m) * centre[-m];
      SetRows(K, k, l, CoefficientIndex(n, m, false), m == 0 ? plus : plus + minus);
      const Complex difference = minus - plus;
      if (m > 0) SetRows(K, k, l, CoefficientIndex(n, m, true), {-difference.imag(), difference.real()});
    });
  });
  return K;
}

std::vector<double> ReflectionSigns(int axes, int order) {
  std::vector<double> signs(CoefficientCount(order));
  ForEachDegree(order, [&](int n, int m) {
    for (bool imaginary : {false, true}) {
      double sign = 1.0;
      if (axes & 1) sign *= AlternatingSign(m) * (imaginary ? -1.0 : 1.0);
      if (axes & 2) sign *= imaginary ? -1.0 : 1.0;
      if (axes & 4) sign *= AlternatingSign(n + m);
      if (m > 0 || !imaginary) signs[CoefficientIndex(n, m, imaginary)] = sign;
    }
  });
  return signs;
}

}  // namespace geond::charge
