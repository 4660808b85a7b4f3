// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>
#include <type_traits>

#if defined(__AVX2__)
#include <immintrin.h>
#endif

// Packs of numbers that are computed on side by side, as wide as the instruction set of the file that includes this,
// and the few functions of them that the compiler does not give. Everything has internal linkage on purpose: each
// instruction set compiles its own copy, and the linker must not take one for another.
//
// With double packs no product is contracted into a sum, so that each lane gives the same bits on every machine.
namespace geond::charge {
namespace {

#if defined(__AVX512F__)
constexpr int kPackBytes = 64;
#elif defined(__AVX2__)
constexpr int kPackBytes = 32;
#else
constexpr int kPackBytes = 16;
#endif

typedef double DoublePack __attribute__((vector_size(kPackBytes)));
typedef std::uint64_t BitsPack __attribute__((vector_size(kPackBytes)));
typedef float FloatPack __attribute__((vector_size(kPackBytes)));
typedef std::int32_t ShortBitsPack __attribute__((vector_size(kPackBytes)));

constexpr int kDoubles = kPackBytes / sizeof(double);
constexpr int kFloats = kPackBytes / sizeof(float);

inline double Sqrt(double x) { return std::sqrt(x); }
inline double Abs(double x) { return std::fabs(x); }
inline double Select(bool mask, double a, double b) { return mask ? a : b; }
inline double Log(double x) { return std::log(x); }
// The angle in [0, pi] of the point (x, y), y >= 0.
inline double AtanOfRatio(double y, double x) { return std::atan2(y, x); }

template <typename Mask>
inline DoublePack Select(Mask mask, DoublePack a, DoublePack b) {
  return mask ? a : b;
}

template <typename Mask>
inline FloatPack Select(Mask mask, FloatPack a, FloatPack b) {
  return mask ? a : b;
}

inline FloatPack Abs(FloatPack x) { return (FloatPack)((ShortBitsPack)x & 0x7fffffff); }

inline FloatPack Sqrt(FloatPack x) {
#if defined(__AVX512F__)
  return _mm512_maskz_sqrt_ps(0xffff, x);
#elif defined(__AVX2__)
  return _mm256_sqrt_ps(x);
#else
  for (int i = 0; i < kFloats; ++i) x[i] = std::sqrt(x[i]);
  return x;
#endif
}

inline DoublePack Abs(DoublePack x) { return (DoublePack)((BitsPack)x & 0x7fffffffffffffffu); }

inline DoublePack Sqrt(DoublePack x) {
#if defined(__AVX512F__)
  return _mm512_maskz_sqrt_pd(0xff, x);
#elif defined(__AVX2__)
  return _mm256_sqrt_pd(x);
#else
  for (int i = 0; i < kDoubles; ++i) x[i] = std::sqrt(x[i]);
  return x;
#endif
}

// For positive normal numbers: x = 2^k m with m in [sqrt(1/2), sqrt 2), ln m = 2 artanh((m - 1)/(m + 1)) by its series,
// whose argument is at most 0.172.
inline DoublePack Log(DoublePack x) {
  constexpr std::uint64_t kSqrtHalf = 0x3fe6a09e667f3bcd, kOne = 0x3ff0000000000000, kMantissa = 0x000fffffffffffff;
  constexpr std::uint64_t kTwoTo52Bits = 0x4330000000000000;
  constexpr double kTwoTo52 = 4503599627370496.0;
  constexpr double kLn2High = 0x1.62e42fefap-1, kLn2Low = 0x1.cf79abc9e3b3ap-40;  // the first exact times any exponent
  const BitsPack bits = (BitsPack)x + (kOne - kSqrtHalf);
  const DoublePack k = (DoublePack)((bits >> 52) | kTwoTo52Bits) - (kTwoTo52 + 1023.0);
  const DoublePack f = (DoublePack)((bits & kMantissa) + kSqrtHalf) - 1.0;
  const DoublePack s = f / (f + 2.0), z = s * s;
  DoublePack series = z * (1.0 / 21.0) + 1.0 / 19.0;
  for (int n = 17; n >= 3; n -= 2) series = series * z + 1.0 / n;
  return k * kLn2High + (2.0 * s + (2.0 * s * (z * series) + k * kLn2Low));
}

inline FloatPack Log(FloatPack x) {
  constexpr std::int32_t kSqrtHalf = 0x3f3504f3, kOne = 0x3f800000, kMantissa = 0x007fffff;
  const ShortBitsPack bits = (ShortBitsPack)x + (kOne - kSqrtHalf);
  const FloatPack k = __builtin_convertvector(bits >> 23, FloatPack) - 127.0f;
  const FloatPack f = (FloatPack)((bits & kMantissa) + kSqrtHalf) - 1.0f;
  const FloatPack s = f / (f + 2.0f), z = s * s;
  const FloatPack series = ((z * (1.0f / 9.0f) + 1.0f / 7.0f) * z + 1.0f / 5.0f) * z + 1.0f / 3.0f;
  return k * 0.693147181f + 2.0f * (s + s * (z * series));
}

// The ratio of the lesser to the greater side is brought within tan(pi/16) of 0 by turning the point back by 0, pi/8 or
// pi/4; the series does the rest.
template <typename Pack>
inline Pack AtanOfRatio(Pack y, Pack x) {
  using Real = std::remove_cvref_t<decltype(x[0])>;
  constexpr Real kPi = 3.14159265358979323846;
  constexpr Real kTanPi16 = 0.19891236737965800691, kTan3Pi16 = 0.66817863791929891999;
  constexpr Real kTanPi8 = 0.41421356237309504880;
  constexpr int kLast = sizeof(Real) == sizeof(float) ? 9 : 23;  // degree of the series
  const Pack a = Abs(x);
  const auto steep = y > a;
  const Pack low = Select(steep, a, y), high = Select(steep, y, a);
  const auto some = low > high * kTanPi16, more = low > high * kTan3Pi16;
  const Pack zero = a * Real(0);
  const Pack turn = Select(more, zero + Real(1), Select(some, zero + kTanPi8, zero));
  const Pack turned = Select(more, zero + kPi / 4, Select(some, zero + kPi / 8, zero));
  const Pack q = (low - turn * high) / (high + turn * low), z = q * q;
  Pack series = zero;
  for (int n = kLast; n >= 3; n -= 2) series = series * z + Real((n / 2) % 2 ? -1.0 : 1.0) / n;
  const Pack flat = turned + (q + q * (z * series));
  const Pack angle = Select(steep, kPi / 2 - flat, flat);
  return Select(x < Real(0), kPi - angle, angle);
}

}  // namespace
}  // namespace geond::charge
