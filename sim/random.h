// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>

namespace geond::sim {

// Random numbers by counter: every draw is a pure function of (seed, stream, index, draw), so that a pixel has its
// noise whatever thread computes it and in whatever order. The mixing is the finaliser of SplitMix64, applied once a
// word.
class CounterRandom {
 public:
  CounterRandom(std::uint64_t seed, std::uint64_t stream, std::uint64_t index)
      : key_(Mix(Mix(Mix(seed) ^ stream) ^ index)) {}

  // In (0, 1), never 0 or 1.
  double Uniform() { return (static_cast<double>(Mix(key_ ^ ++draw_) >> 11) + 0.5) * 0x1.0p-53; }
  // Mean 0, standard deviation 1 (Box and Muller 1958); two draws.
  double Normal() {
    const double radius = std::sqrt(-2.0 * std::log(Uniform()));
    return radius * std::cos(2.0 * std::numbers::pi * Uniform());
  }

 private:
  static std::uint64_t Mix(std::uint64_t x) {
    x += 0x9e3779b97f4a7c15u;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    return x ^ (x >> 31);
  }
  std::uint64_t key_;
  std::uint64_t draw_ = 0;
};

}  // namespace geond::sim
