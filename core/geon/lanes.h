// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <initializer_list>

#if defined(__AVX2__)
#include <immintrin.h>
#endif

#include "core/geon/misfit_loops.h"

// Eight doubles at a time and the few functions the objective needs of them, in a namespace of its own for each instruction
// set. All instruction sets with fused multiplication and addition compute the same bits.
#pragma GCC diagnostic ignored "-Wpsabi"

namespace geond::lanes {
namespace {

#define GEOND_LANES_INLINE inline __attribute__((always_inline))

typedef double Lanes __attribute__((vector_size(kLanes * sizeof(double))));
typedef std::int64_t LaneBits __attribute__((vector_size(kLanes * sizeof(std::int64_t))));

GEOND_LANES_INLINE Lanes Splat(double x) { return Lanes{} + x; }
GEOND_LANES_INLINE Lanes Load(const double* p) {
  Lanes x;
  __builtin_memcpy(&x, p, sizeof x);
  return x;
}
// a b + c, rounded once where the processor can.
GEOND_LANES_INLINE Lanes MulAdd(Lanes a, Lanes b, Lanes c) {
#if defined(__AVX512F__)
  return (Lanes)_mm512_fmadd_pd((__m512d)a, (__m512d)b, (__m512d)c);
#elif defined(__FMA__)
  union Halves {
    Lanes whole;
    __m256d part[2];
  };
  const Halves x{a}, y{b}, z{c};
  Halves sum;
  for (int i = 0; i < 2; ++i) sum.part[i] = _mm256_fmadd_pd(x.part[i], y.part[i], z.part[i]);
  return sum.whole;
#else
  return a * b + c;
#endif
}
// c - a b.
GEOND_LANES_INLINE Lanes LessMul(Lanes c, Lanes a, Lanes b) { return MulAdd(-a, b, c); }
GEOND_LANES_INLINE Lanes Dot(const Lanes (&a)[3], const Lanes (&b)[3]) {
  return MulAdd(a[0], b[0], MulAdd(a[1], b[1], a[2] * b[2]));
}
GEOND_LANES_INLINE Lanes Max(Lanes a, Lanes b) { return a > b ? a : b; }
GEOND_LANES_INLINE Lanes Min(Lanes a, Lanes b) { return a < b ? a : b; }
GEOND_LANES_INLINE Lanes Abs(Lanes a) { return a < 0.0 ? -a : a; }

// 1 / sqrt(x) for positive normal x, to 2e-16 or so; large and finite at 0.
GEOND_LANES_INLINE Lanes InverseSqrt(Lanes x) {
  Lanes y = (Lanes)(0x5fe6eb50c7b537a9 - ((LaneBits)x >> 1));
  const Lanes half = 0.5 * x;
  for (int i = 0; i < 4; ++i) y = y * LessMul(Splat(1.5), half * y, y);
  return y;
}

GEOND_LANES_INLINE Lanes Power9(Lanes x) {   // of a square: x^18
  const Lanes x2 = x * x, x4 = x2 * x2;
  return x4 * x4 * x;
}

// x^(-1/20) for 1 <= x <= 3: a polynomial (1e-5) and two steps of Newton.
GEOND_LANES_INLINE Lanes InverseRoot20(Lanes x) {
  Lanes y = Splat(-0.00045124066733822987);
  for (const double k : {0.0056061716080535997, -0.028918761147060209, 0.081295510536752852, -0.14560618366513819,
                         1.088063716516638}) {
    y = MulAdd(y, x, Splat(k));
  }
  for (int i = 0; i < 2; ++i) {
    const Lanes y2 = y * y, y4 = y2 * y2, y8 = y4 * y4;
    y = y * LessMul(Splat(1.05), 0.05 * x, y8 * y8 * y4);
  }
  return y;
}

// Angle of (c, s), r = hypot(s, c) > 0, in [-pi, pi].
GEOND_LANES_INLINE Lanes Angle(Lanes s, Lanes c, Lanes r) {
  const Lanes u = Abs(s) / (r + Abs(c));   // tan of half the angle to the nearer half axis, 0 to 1
  const auto large = u > 0.41421356237309503;
  const Lanes v = large ? (u - 1.0) / (u + 1.0) : u;
  const Lanes z = v * v;
  Lanes p = 0.015113188421315578 + Lanes{};
  for (const double k : {-0.033387254662610874, 0.044994761370224005, -0.052173064890151256, 0.058768330517689142,
                         -0.06666205161654902, 0.0769228109318707, -0.090909080587269486, 0.11111111085313444,
                         -0.14285714285329562, 0.19999999999997012, -0.33333333333333326, 1.0}) {
    p = MulAdd(p, z, Splat(k));
  }
  Lanes half = v * p;
  half = large ? half + 0.78539816339744831 : half;
  Lanes angle = 2.0 * half;
  angle = c < 0.0 ? 3.14159265358979312 - angle : angle;
  return s < 0.0 ? -angle : angle;
}

// Sine and cosine for |t| up to some pi, by a quarter of the angle doubled twice.
GEOND_LANES_INLINE void SineCosine(Lanes t, Lanes& sine, Lanes& cosine) {
  const Lanes h = 0.25 * t, z = h * h;
  Lanes s = Splat(-1.0 / 1307674368000.0);
  for (const double k : {1.0 / 6227020800.0, -1.0 / 39916800, 1.0 / 362880, -1.0 / 5040, 1.0 / 120, -1.0 / 6, 1.0}) {
    s = MulAdd(s, z, Splat(k));
  }
  s *= h;
  // 1 - cos, so that small angles keep their digits.
  Lanes v = Splat(-1.0 / 20922789888000.0);
  for (const double k : {1.0 / 87178291200.0, -1.0 / 479001600, 1.0 / 3628800, -1.0 / 40320, 1.0 / 720, -1.0 / 24, 0.5}) {
    v = MulAdd(v, z, Splat(k));
  }
  v *= z;
  for (int i = 0; i < 2; ++i) {
    const Lanes twice = 2.0 * s * (1.0 - v);
    v = 2.0 * s * s;
    s = twice;
  }
  sine = s;
  cosine = 1.0 - v;
}

}  // namespace
}  // namespace geond::lanes
