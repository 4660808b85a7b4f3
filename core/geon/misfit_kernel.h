// SPDX-License-Identifier: Apache-2.0
#pragma once

// The objective of eight points and its derivatives, in closed form. With d the datum in G, u = d undeformed, y = u / a,
// s the gauge (f^(1/p)), m its gradient by u: e = |u| (1 - 1/s), surface point x = u / s, n_m = b / |b| with b = B(x) m,
// B = (det J) J^-T of (5.16), (5.17). m does not change along a ray, so it needs no surface point. Seen in T, every
// derivative of n_m is tangent to the model: two coordinates say it.
// To be included only by the files of one instruction set each.

#include "core/geon/lanes.h"
#include "core/geon/misfit_loops.h"

namespace geond::lanes {
namespace {

enum class Base { kEllipsoid, kRound, kBox };
enum class Bending { kNone, kTapered, kCurved };

inline constexpr int CountOf(Bending bending) {
  return bending == Bending::kTapered ? 11 : bending == Bending::kCurved ? 10 : 9;
}

// One column of the derivatives: of e, and of n_m along two unit tangents of the model there.
struct Column {
  Lanes e, t[2];
};

GEOND_LANES_INLINE void AddScaled(Column& to, Lanes f, const Column& c) {
  to.e = MulAdd(f, c.e, to.e);
  for (int a = 0; a < 2; ++a) to.t[a] = MulAdd(f, c.t[a], to.t[a]);
}

// What a block of eight points gives; the last two only if asked for, the columns in the order of the parameters.
struct BlockResult {
  Lanes e, normal;      // normal: |n_d - n_m|^2
  Lanes tangent[2];     // n_m - n_d along the tangents
  Column column[kMostParameters];
};

GEOND_LANES_INLINE Lanes Power10(Lanes x) {
  const Lanes x2 = x * x, x4 = x2 * x2;
  return x4 * x4 * x2;
}

template <Base kBase, Bending kBending, bool kDerivatives>
GEOND_LANES_INLINE void EvaluateBlock(const PlainState& g, const PlainPoints& points, int at, BlockResult& out) {
  constexpr bool kTapered = kBending == Bending::kTapered, kCurved = kBending == Bending::kCurved;
  Lanes d[3], nd[3];
  {
    Lanes p[3], n[3];
    for (int i = 0; i < 3; ++i) {
      p[i] = Load(points.point[i] + at) - g.center[i];
      n[i] = Load(points.normal[i] + at);
    }
    for (int i = 0; i < 3; ++i) {
      const Lanes axis[3] = {Splat(g.rotation[0][i]), Splat(g.rotation[1][i]), Splat(g.rotation[2][i])};
      d[i] = Dot(axis, p);
      nd[i] = Dot(axis, n);
    }
  }
  const double ia[3] = {1.0 / g.size[0], 1.0 / g.size[1], 1.0 / g.size[2]};

  // Undeform.
  Lanes u[3] = {d[0], d[1], d[2]};
  Lanes inverse_factor[2], guarded[2];   // taper: 1/factor, and 1 where the factor is its true value
  Lanes bend_r{}, bend_c{}, bend_s{};    // bend: R, cos and sin of the datum's angle
  const double k[2] = {kTapered ? g.deformation[0] * ia[2] : g.deformation[0], kTapered ? g.deformation[1] * ia[2] : 0.0};
  if constexpr (kTapered) {
    for (int i = 0; i < 2; ++i) {
      const Lanes factor = MulAdd(Splat(k[i]), d[2], Splat(1.0));
      const Lanes guard = Splat(1e-3);
      guarded[i] = factor > guard ? Splat(1.0) : Splat(0.0);
      inverse_factor[i] = 1.0 / Max(factor, guard);
      u[i] = d[i] * inverse_factor[i];
    }
  }
  if constexpr (kCurved) {
    const Lanes c = LessMul(Splat(1.0), Splat(k[0]), d[0]), s = k[0] * d[2];
    const Lanes square = Max(MulAdd(c, c, s * s), Splat(1e-280));
    const Lanes inverse = InverseSqrt(square);
    bend_r = square * inverse;
    bend_c = c * inverse;
    bend_s = s * inverse;
    u[0] = (2.0 * d[0] - k[0] * MulAdd(d[0], d[0], d[2] * d[2])) / (1.0 + bend_r);
    if (k[0] > 1e-12) u[2] = Angle(s, c, bend_r) / k[0];
  }

  // Gauge: 1/s, and eta = y / s on the unit surface.
  Lanes y[3], eta[3];
  for (int i = 0; i < 3; ++i) y[i] = u[i] * ia[i];
  const Lanes q[3] = {y[0] * y[0], y[1] * y[1], y[2] * y[2]};
  const Lanes tiny = Splat(1e-280);
  Lanes largest, inverse_s;
  if constexpr (kBase == Base::kEllipsoid) {
    largest = Max(q[0] + q[1] + q[2], tiny);
    inverse_s = InverseSqrt(largest);
  } else {
    const Lanes qr = kBase == Base::kRound ? q[0] + q[1] : Max(q[0], q[1]);
    largest = Max(Max(qr, q[2]), tiny);
    const Lanes inverse = 1.0 / largest;
    Lanes sum = Power10(q[2] * inverse);
    if constexpr (kBase == Base::kRound) sum += Power10(qr * inverse);
    else sum += Power10(q[0] * inverse) + Power10(q[1] * inverse);
    inverse_s = InverseSqrt(largest) * InverseRoot20(Max(sum, Splat(1.0)));
  }
  for (int i = 0; i < 3; ++i) eta[i] = y[i] * inverse_s;

  // Gradient by y (sigma) and by u (m).
  Lanes sigma[3], m[3];
  Lanes p18[3];   // eta^18 of each axis; the radius' for the round ones
  if constexpr (kBase == Base::kEllipsoid) {
    for (int i = 0; i < 3; ++i) sigma[i] = eta[i];
  } else {
    const Lanes e0 = eta[0] * eta[0], e1 = eta[1] * eta[1];
    p18[0] = Power9(kBase == Base::kRound ? e0 + e1 : e0);
    p18[1] = kBase == Base::kRound ? p18[0] : Power9(e1);
    p18[2] = Power9(eta[2] * eta[2]);
    for (int i = 0; i < 3; ++i) sigma[i] = p18[i] * eta[i];
  }
  for (int i = 0; i < 3; ++i) m[i] = sigma[i] * ia[i];

  const Lanes length_square = Max(Dot(u, u), tiny);
  const Lanes inverse_length = InverseSqrt(length_square);
  const Lanes length = length_square * inverse_length;
  const double least = g.size[0] < g.size[1] ? g.size[0] : g.size[1];
  out.e = largest > tiny ? LessMul(length, length, inverse_s) : Splat(least < g.size[2] ? -least : -g.size[2]);

  // Normal of the deformed surface at x = u / s.
  Lanes x[3], b[3];
  for (int i = 0; i < 3; ++i) x[i] = u[i] * inverse_s;
  Lanes h0{}, h1{}, rho{}, c{}, sn{};
  if constexpr (kTapered) {
    h0 = MulAdd(Splat(k[0]), x[2], Splat(1.0));
    h1 = MulAdd(Splat(k[1]), x[2], Splat(1.0));
    b[0] = h1 * m[0];
    b[1] = h0 * m[1];
    b[2] = LessMul(LessMul(h0 * h1 * m[2], k[0] * x[0], b[0]), k[1] * x[1], b[1]);
  } else if constexpr (kCurved) {
    SineCosine(k[0] * x[2], sn, c);
    rho = LessMul(Splat(1.0), Splat(k[0]), x[0]);
    b[0] = MulAdd(rho * c, m[0], sn * m[2]);
    b[1] = rho * m[1];
    b[2] = LessMul(c * m[2], rho * sn, m[0]);
  } else {
    for (int i = 0; i < 3; ++i) b[i] = m[i];
  }
  const Lanes inverse_b = InverseSqrt(Max(Dot(b, b), tiny));
  Lanes n[3], difference[3];
  for (int i = 0; i < 3; ++i) {
    n[i] = b[i] * inverse_b;
    difference[i] = n[i] - nd[i];
  }
  out.normal = Dot(difference, difference);
  if constexpr (!kDerivatives) return;

  // Unit tangents t with t[0] x t[1] = n, and for each T = t / |b|, W = B' T: a change of m by v turns n_m by W . v along t.
  const Lanes sign = n[2] < 0.0 ? Splat(-1.0) : Splat(1.0);
  const Lanes a = -1.0 / (sign + n[2]), ab = n[0] * n[1] * a;
  const Lanes t[2][3] = {{MulAdd(sign * n[0], n[0] * a, Splat(1.0)), sign * ab, -sign * n[0]},
                         {ab, MulAdd(n[1] * a, n[1], sign), -n[1]}};
  // db/dx_i along the tangents, and their sums along x.
  Lanes w[2][3], bt[2][3], by_x[2][3] = {}, along_x[2] = {};
  for (int i = 0; i < 2; ++i) {
    for (int j = 0; j < 3; ++j) bt[i][j] = t[i][j] * inverse_b;
    if constexpr (kTapered) {
      w[i][0] = h1 * LessMul(bt[i][0], k[0] * x[0], bt[i][2]);
      w[i][1] = h0 * LessMul(bt[i][1], k[1] * x[1], bt[i][2]);
      w[i][2] = h0 * h1 * bt[i][2];
      by_x[i][0] = -k[0] * h1 * m[0] * bt[i][2];
      by_x[i][1] = -k[1] * h0 * m[1] * bt[i][2];
      by_x[i][2] = MulAdd(k[1] * m[0], bt[i][0],
                          MulAdd(k[0] * m[1], bt[i][1],
                                 bt[i][2] * ((k[0] * h1 + k[1] * h0) * m[2] -
                                             (k[0] * k[1]) * MulAdd(x[0], m[0], x[1] * m[1]))));
    } else if constexpr (kCurved) {
      w[i][0] = rho * LessMul(c * bt[i][0], sn, bt[i][2]);
      w[i][1] = rho * bt[i][1];
      w[i][2] = MulAdd(sn, bt[i][0], c * bt[i][2]);
      by_x[i][0] = k[0] * (sn * m[0] * bt[i][2] - c * m[0] * bt[i][0] - m[1] * bt[i][1]);
      by_x[i][2] = k[0] * (LessMul(c * m[2], rho * sn, m[0]) * bt[i][0] - MulAdd(sn, m[2], rho * c * m[0]) * bt[i][2]);
    } else {
      for (int j = 0; j < 3; ++j) w[i][j] = bt[i][j];
    }
    if constexpr (kBending != Bending::kNone) along_x[i] = Dot(by_x[i], x);
  }

  // Derivatives by u and by the sizes. The second derivative of the gauge by u is a matrix of rank one and a diagonal.
  const Lanes along = 1.0 - inverse_s, across = length * inverse_s * inverse_s;
  Column by_u[3], by_size[3];
  for (int j = 0; j < 3; ++j) {
    by_u[j].e = MulAdd(across, m[j], u[j] * inverse_length * along);
    by_size[j].e = -across * y[j] * m[j];
  }
  Lanes radial{};
  if constexpr (kBase == Base::kRound) radial = 18.0 * p18[0] / Max(MulAdd(eta[0], eta[0], eta[1] * eta[1]), tiny);
  for (int i = 0; i < 2; ++i) {
    Lanes v[3];
    for (int j = 0; j < 3; ++j) v[j] = w[i][j] * ia[j];
    const Lanes mean = kBase == Base::kEllipsoid ? -Dot(v, eta) : -19.0 * Dot(v, sigma);
    for (int j = 0; j < 3; ++j) {
      Lanes turn;
      if constexpr (kBase == Base::kEllipsoid) {
        turn = MulAdd(mean, eta[j], v[j]);
      } else if (kBase == Base::kRound && j < 2) {
        turn = MulAdd(mean, sigma[j], MulAdd(radial * eta[j], MulAdd(v[0], eta[0], v[1] * eta[1]), p18[0] * v[j]));
      } else {
        turn = MulAdd(mean, sigma[j], 19.0 * p18[j] * v[j]);
      }
      turn = turn * (inverse_s * ia[j]);
      by_u[j].t[i] = turn;
      by_size[j].t[i] = LessMul(-y[j] * turn, v[j], m[j]);
      if constexpr (kBending != Bending::kNone) {
        by_u[j].t[i] = MulAdd(LessMul(by_x[i][j], along_x[i], m[j]), inverse_s, by_u[j].t[i]);
        by_size[j].t[i] = MulAdd(along_x[i] * inverse_s, y[j] * m[j], by_size[j].t[i]);
      }
    }
  }

  // By the deformation, and from u to the datum d.
  Column by_d[3] = {by_u[0], by_u[1], by_u[2]};
  if constexpr (kTapered) {
    Column by_k[2];   // by K / az
    for (int i = 0; i < 2; ++i) {
      by_k[0].t[i] = x[2] * m[1] * bt[i][1] + (x[2] * (h1 * m[2] - k[1] * x[1] * m[1]) - h1 * x[0] * m[0]) * bt[i][2];
      by_k[1].t[i] = x[2] * m[0] * bt[i][0] + (x[2] * (h0 * m[2] - k[0] * x[0] * m[0]) - h0 * x[1] * m[1]) * bt[i][2];
    }
    for (int i = 0; i < 2; ++i) {
      by_k[i].e = Lanes{};
      AddScaled(by_k[i], -u[i] * d[2] * inverse_factor[i] * guarded[i], by_u[i]);
      by_d[i].e = by_u[i].e * inverse_factor[i];
      for (int l = 0; l < 2; ++l) by_d[i].t[l] = by_u[i].t[l] * inverse_factor[i];
      AddScaled(by_d[2], -k[i] * u[i] * inverse_factor[i] * guarded[i], by_u[i]);
      AddScaled(by_size[2], Splat(-k[i] * ia[2]), by_k[i]);
    }
    for (int i = 0; i < 2; ++i) out.column[9 + i] = {by_k[i].e * ia[2], {by_k[i].t[0] * ia[2], by_k[i].t[1] * ia[2]}};
  }
  if constexpr (kCurved) {
    Column& by_bend = out.column[9];
    const Lanes turn[3] = {c * m[2] - rho * sn * m[0], Lanes{}, -sn * m[2] - rho * c * m[0]};
    const Lanes shrink[3] = {-c * m[0], -m[1], sn * m[0]};
    by_bend.e = Lanes{};
    for (int i = 0; i < 2; ++i) by_bend.t[i] = MulAdd(x[0], Dot(shrink, bt[i]), x[2] * Dot(turn, bt[i]));
    const Lanes inverse_r = 1.0 / bend_r;
    const Lanes r_by_k = (k[0] * d[2] * d[2] - d[0] * (1.0 - k[0] * d[0])) * inverse_r;
    const Lanes x_by_k = -(d[0] * d[0] + d[2] * d[2] + u[0] * r_by_k) / (1.0 + bend_r);
    const Lanes z_by_k = k[0] > 1e-7 ? (d[2] * inverse_r * inverse_r - u[2]) / k[0] : d[0] * d[2];
    AddScaled(by_bend, x_by_k, by_u[0]);
    AddScaled(by_bend, z_by_k, by_u[2]);
    by_d[0] = by_d[2] = Column{Lanes{}, {Lanes{}, Lanes{}}};
    AddScaled(by_d[0], bend_c, by_u[0]);
    AddScaled(by_d[0], bend_s * inverse_r, by_u[2]);
    AddScaled(by_d[2], -bend_s, by_u[0]);
    AddScaled(by_d[2], bend_c * inverse_r, by_u[2]);
  }

  // Moving G by tau moves d by -tau; turning it by w moves d by d x w and, seen in T, n_m by w x n_m.
  for (int j = 0; j < 3; ++j) {
    const int p = (j + 1) % 3, l = (j + 2) % 3;
    Column& turn = out.column[j];
    turn.e = LessMul(by_d[p].e * d[l], by_d[l].e, d[p]);
    for (int i = 0; i < 2; ++i) turn.t[i] = LessMul(by_d[p].t[i] * d[l], by_d[l].t[i], d[p]);
    turn.t[0] += t[1][j];
    turn.t[1] -= t[0][j];
    out.column[3 + j] = {-by_d[j].e, {-by_d[j].t[0], -by_d[j].t[1]}};
    out.column[6 + j] = by_size[j];
  }
  for (int i = 0; i < 2; ++i) out.tangent[i] = -Dot(t[i], nd);
}

GEOND_LANES_INLINE double Sum(Lanes x) {
  return ((x[0] + x[1]) + (x[2] + x[3])) + ((x[4] + x[5]) + (x[6] + x[7]));
}

// The sums that are wanted with and without derivatives.
struct LaneSums {
  Lanes weight{}, distance{}, smooth{}, normal{}, covered{};

  // Adds a block; what its points weigh in distances and in normals to `by_distance` and `by_normal`.
  GEOND_LANES_INLINE void Add(const BlockResult& block, const PlainPoints& points, int at, double floor, Lanes& by_distance,
                              Lanes& by_normal) {
    const Lanes w = Load(points.weight + at), empty = Load(points.empty + at);
    const Lanes magnitude = Abs(block.e);
    by_normal = w * (1.0 - empty);
    const Lanes counted = block.e < 0.0 ? w : by_normal;   // of empty places those inside the geon
    const Lanes rounded = magnitude > floor ? magnitude : 0.5 * (magnitude * magnitude / (floor + 1e-280) + floor);
    weight += by_normal;
    distance = MulAdd(by_normal, magnitude, distance);
    normal = MulAdd(by_normal, block.normal, normal);
    covered = MulAdd(counted - by_normal, magnitude, covered);
    smooth = MulAdd(counted, rounded - 0.5 * floor * empty, smooth);
    by_distance = counted / Max(magnitude, Splat(floor));
  }
  GEOND_LANES_INLINE PlainSums Total() const {
    return {Sum(weight), Sum(distance), Sum(smooth), Sum(normal), Sum(covered)};
  }
};

template <Base kBase, Bending kBending>
PlainSums SumBlocks(const PlainState& g, const PlainPoints& points, double floor) {
  LaneSums sums;
  BlockResult block;
  for (int at = 0; at < points.padded; at += kLanes) {
    EvaluateBlock<kBase, kBending, false>(g, points, at, block);
    Lanes by_distance, by_normal;
    sums.Add(block, points, at, floor, by_distance, by_normal);
  }
  return sums.Total();
}

GEOND_LANES_INLINE Column Scaled(const Column& c, Lanes by_distance, Lanes by_normal) {
  return {by_distance * c.e, {by_normal * c.t[0], by_normal * c.t[1]}};
}
GEOND_LANES_INLINE void AddProduct(Lanes& sum, const Column& a, const Column& b) {
  sum = MulAdd(a.e, b.e, MulAdd(a.t[0], b.t[0], MulAdd(a.t[1], b.t[1], sum)));
}

template <Base kBase, Bending kBending>
void DifferentiateBlocks(const PlainState& g, const PlainPoints& points, double normal_weight, double floor,
                         PlainDerivatives& out) {
  constexpr int n = CountOf(kBending);
  LaneSums sums;
  Lanes hessian[n * (n + 1) / 2] = {}, distance_gradient[n] = {}, normal_gradient[n] = {};
  BlockResult block;
  for (int at = 0; at < points.padded; at += kLanes) {
    EvaluateBlock<kBase, kBending, true>(g, points, at, block);
    Lanes by_distance, by_normal;
    sums.Add(block, points, at, floor, by_distance, by_normal);
    const Lanes weighted_e = by_distance * block.e, r0 = by_normal * block.tangent[0], r1 = by_normal * block.tangent[1];
    const Lanes wn = by_normal * normal_weight;
    // The lower triangle two rows at a time, which read the columns once; unrolled, since nobody but us knows how short it is.
#pragma GCC unroll 6
    for (int j = 0; j < n; j += 2) {
      const Column& upper = block.column[j];
      const Column a = Scaled(upper, by_distance, wn);
      Lanes* const upper_sums = hessian + j * (j + 1) / 2;
      distance_gradient[j] = MulAdd(weighted_e, upper.e, distance_gradient[j]);
      normal_gradient[j] = MulAdd(r0, upper.t[0], MulAdd(r1, upper.t[1], normal_gradient[j]));
      if (j + 1 == n) {
#pragma GCC unroll 11
        for (int l = 0; l <= j; ++l) AddProduct(upper_sums[l], a, block.column[l]);
        break;
      }
      const Column& lower = block.column[j + 1];
      const Column b = Scaled(lower, by_distance, wn);
      Lanes* const lower_sums = upper_sums + j + 1;
      distance_gradient[j + 1] = MulAdd(weighted_e, lower.e, distance_gradient[j + 1]);
      normal_gradient[j + 1] = MulAdd(r0, lower.t[0], MulAdd(r1, lower.t[1], normal_gradient[j + 1]));
#pragma GCC unroll 11
      for (int l = 0; l <= j; ++l) {
        AddProduct(upper_sums[l], a, block.column[l]);
        AddProduct(lower_sums[l], b, block.column[l]);
      }
      AddProduct(lower_sums[j + 1], b, lower);
    }
  }
  out.sums = sums.Total();
  for (int j = 0; j < n; ++j) {
    out.distance_gradient[j] = Sum(distance_gradient[j]);
    out.normal_gradient[j] = Sum(normal_gradient[j]);
  }
  for (int i = 0; i < n * (n + 1) / 2; ++i) out.hessian[i] = Sum(hessian[i]);
}

inline constexpr Loops MakeLoops() {
  return {{SumBlocks<Base::kEllipsoid, Bending::kNone>, SumBlocks<Base::kRound, Bending::kNone>,
           SumBlocks<Base::kBox, Bending::kNone>, SumBlocks<Base::kRound, Bending::kTapered>,
           SumBlocks<Base::kBox, Bending::kTapered>, SumBlocks<Base::kRound, Bending::kCurved>,
           SumBlocks<Base::kBox, Bending::kCurved>},
          {DifferentiateBlocks<Base::kEllipsoid, Bending::kNone>, DifferentiateBlocks<Base::kRound, Bending::kNone>,
           DifferentiateBlocks<Base::kBox, Bending::kNone>, DifferentiateBlocks<Base::kRound, Bending::kTapered>,
           DifferentiateBlocks<Base::kBox, Bending::kTapered>, DifferentiateBlocks<Base::kRound, Bending::kCurved>,
           DifferentiateBlocks<Base::kBox, Bending::kCurved>}};
}

}  // namespace
}  // namespace geond::lanes
