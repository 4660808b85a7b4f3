// SPDX-License-Identifier: Apache-2.0
#include "core/charge/circulant.h"

#include <bit>
#include <numbers>

namespace geond::charge {
namespace {

using Complex = std::complex<double>;

inline Complex Times(Complex a, Complex b) {
  return {a.real() * b.real() - a.imag() * b.imag(), a.real() * b.imag() + a.imag() * b.real()};
}

// From the natural order to the reversed one of bits, and back without the factor 1/size (Cooley and Tukey 1965).
void Forward(std::vector<Complex>& values, const std::vector<Complex>& roots) {
  for (std::size_t half = values.size() / 2, stride = 1; half > 0; half /= 2, stride *= 2) {
    for (std::size_t begin = 0; begin < values.size(); begin += 2 * half) {
      for (std::size_t k = 0; k < half; ++k) {
        const Complex a = values[begin + k], b = values[begin + half + k];
        values[begin + k] = a + b;
        values[begin + half + k] = Times(a - b, roots[k * stride]);
      }
    }
  }
}

void Backward(std::vector<Complex>& values, const std::vector<Complex>& roots) {
  for (std::size_t half = 1, stride = values.size() / 2; half < values.size(); half *= 2, stride /= 2) {
    for (std::size_t begin = 0; begin < values.size(); begin += 2 * half) {
      for (std::size_t k = 0; k < half; ++k) {
        const Complex a = values[begin + k], b = Times(values[begin + half + k], std::conj(roots[k * stride]));
        values[begin + k] = a + b;
        values[begin + half + k] = a - b;
      }
    }
  }
}

}  // namespace

Circulant::Circulant(std::span<const double> first) : n_(first.size()) {
  const std::size_t size = std::bit_ceil(2 * n_);
  roots_.resize(size / 2);
  for (std::size_t k = 0; k < roots_.size(); ++k) {
    roots_[k] = std::polar(1.0, -2.0 * std::numbers::pi * static_cast<double>(k) / static_cast<double>(size));
  }
  // The column from -(n - 1) to n - 1, which no product of n numbers overruns.
  spectrum_.assign(size, 0.0);
  for (std::size_t i = 0; i < n_; ++i) {
    spectrum_[i] = first[i];
    if (i > 0) spectrum_[size - i] = first[n_ - i];
  }
  Forward(spectrum_, roots_);
  for (Complex& value : spectrum_) value /= static_cast<double>(size);
}

void Circulant::Apply(std::span<const double> x, std::span<double> y) const {
  std::vector<Complex> values(spectrum_.size());
  for (std::size_t i = 0; i < n_; ++i) values[i] = x[i];
  Forward(values, roots_);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = Times(values[i], spectrum_[i]);
  Backward(values, roots_);
  for (std::size_t i = 0; i < n_; ++i) y[i] = values[i].real();
}

}  // namespace geond::charge
