// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <complex>
#include <span>
#include <vector>

namespace geond::charge {

// y = C x with C_ij = first[|i - j|], |i - j| taken round the circle, by fast Fourier transforms of twice the size
// rounded up to a power of two.
class Circulant {
 public:
  explicit Circulant(std::span<const double> first);
  void Apply(std::span<const double> x, std::span<double> y) const;

 private:
  using Complex = std::complex<double>;
  std::size_t n_;
  std::vector<Complex> roots_;     // e^(-2 pi i k/size), k < size/2
  std::vector<Complex> spectrum_;  // of the first column, in the order the transform leaves it in
};

}  // namespace geond::charge
