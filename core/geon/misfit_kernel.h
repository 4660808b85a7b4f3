// SPDX-License-Identifier: Apache-2.0
#pragma once

// The objective of eight points and its derivatives, in closed form. With d the datum in G, u = d undeformed, y = u / a,
// s the gauge (f^(1/p)), m its gradient by u: e = |u| (1 - 1/s), surface point x = u / s, n_m = b / |b| with b = B(x) m,
// B = (det J) J^-T of (5.16), (5.17). m does not change along a ray, so it needs no surface point.

#include "core/geon/lanes.h"
#include "core/geon/misfit.h"

namespace geond::lanes {

inline constexpr bool TaperedKind(GeonType t) {
  return t == GeonType::kTaperedCylinder || t == GeonType::kTaperedCuboid;
}
inline constexpr bool CurvedKind(GeonType t) { return t == GeonType::kCurvedCylinder || t == GeonType::kCurvedCuboid; }
inline constexpr bool RoundKind(GeonType t) {
  return t == GeonType::kCylinder || t == GeonType::kTaperedCylinder || t == GeonType::kCurvedCylinder;
}
inline constexpr int CountOf(GeonType t) { return TaperedKind(t) ? 11 : CurvedKind(t) ? 10 : 9; }

// One column of the derivatives: of e and of b or n_m.
struct Column {
  Lanes e, n[3];
};

GEOND_LANES_INLINE void AddScaled(Column& to, Lanes f, const Column& c) {
  to.e += f * c.e;
  for (int i = 0; i < 3; ++i) to.n[i] += f * c.n[i];
}

// What a block of eight points gives; columns only if asked for, in the order of the parameters.
struct BlockResult {
  Lanes e, difference[3];   // n_m - n_d in G
  Column column[kMaxParameters];
};

template <GeonType kType, bool kDerivatives>
GEOND_LANES_INLINE void EvaluateBlock(const GeonState& g, const LanePoints& points, int at, BlockResult& out) {
  constexpr bool kTapered = TaperedKind(kType), kCurved = CurvedKind(kType), kEllipsoid = kType == GeonType::kEllipsoid;
  const Eigen::Matrix3d& r = g.rotation;
  Lanes d[3], nd[3];
  {
    const Lanes p[3] = {Load(&points.point[0][at]) - g.center[0], Load(&points.point[1][at]) - g.center[1],
                        Load(&points.point[2][at]) - g.center[2]};
    const Lanes n[3] = {Load(&points.normal[0][at]), Load(&points.normal[1][at]), Load(&points.normal[2][at])};
    for (int i = 0; i < 3; ++i) {
      d[i] = r(0, i) * p[0] + r(1, i) * p[1] + r(2, i) * p[2];
      nd[i] = r(0, i) * n[0] + r(1, i) * n[1] + r(2, i) * n[2];
    }
  }
  const double ia[3] = {1.0 / g.size[0], 1.0 / g.size[1], 1.0 / g.size[2]};

  // Undeform.
  Lanes u[3] = {d[0], d[1], d[2]};
  Lanes inverse_factor[2], guarded[2];   // taper: 1/factor, and 1 where the factor is its true value
  Lanes bend_r{}, bend_c{}, bend_s{};    // bend: R, cos and sin of the datum's angle
  const double k0 = kTapered ? g.deformation[0] * ia[2] : g.deformation[0];
  const double k1 = kTapered ? g.deformation[1] * ia[2] : 0.0;
  if constexpr (kTapered) {
    const double k[2] = {k0, k1};
    for (int i = 0; i < 2; ++i) {
      const Lanes factor = 1.0 + k[i] * d[2];
      const Lanes guard = Splat(1e-3);
      guarded[i] = factor > guard ? Splat(1.0) : Splat(0.0);
      inverse_factor[i] = 1.0 / Max(factor, guard);
      u[i] = d[i] * inverse_factor[i];
    }
  }
  if constexpr (kCurved) {
    const Lanes c = 1.0 - k0 * d[0], s = k0 * d[2];
    const Lanes square = Max(c * c + s * s, Splat(1e-280));
    const Lanes inverse = InverseSqrt(square);
    bend_r = square * inverse;
    bend_c = c * inverse;
    bend_s = s * inverse;
    u[0] = (2.0 * d[0] - k0 * (d[0] * d[0] + d[2] * d[2])) / (1.0 + bend_r);
    if (k0 > 1e-12) u[2] = Angle(s, c, bend_r) / k0;
  }

  // Gauge: 1/s, and eta = y / s on the unit surface.
  Lanes y[3], eta[3];
  for (int i = 0; i < 3; ++i) y[i] = u[i] * ia[i];
  Lanes inverse_s;
  const Lanes q0 = y[0] * y[0], q1 = y[1] * y[1], q2 = y[2] * y[2];
  const Lanes tiny = Splat(1e-280);
  Lanes largest;
  if constexpr (kEllipsoid) {
    largest = Max(q0 + q1 + q2, tiny);
    inverse_s = InverseSqrt(largest);
  } else {
    const Lanes qr = RoundKind(kType) ? q0 + q1 : Max(q0, q1);
    largest = Max(Max(qr, q2), tiny);
    const Lanes inverse = 1.0 / largest;
    const auto power10 = [](Lanes x) __attribute__((always_inline)) {
      const Lanes x2 = x * x, x4 = x2 * x2;
      return x4 * x4 * x2;
    };
    Lanes sum = power10(q2 * inverse);
    if constexpr (RoundKind(kType)) sum += power10(qr * inverse);
    else sum += power10(q0 * inverse) + power10(q1 * inverse);
    inverse_s = InverseSqrt(largest) * InverseRoot20(Max(sum, Splat(1.0)));
  }
  for (int i = 0; i < 3; ++i) eta[i] = y[i] * inverse_s;

  // Gradient by y (sigma) and by u (m).
  Lanes sigma[3], m[3];
  Lanes p18[3];   // eta^18 of each axis; the radius' for the round ones
  if constexpr (kEllipsoid) {
    for (int i = 0; i < 3; ++i) sigma[i] = eta[i];
  } else {
    const Lanes e0 = eta[0] * eta[0], e1 = eta[1] * eta[1];
    p18[0] = Power9(RoundKind(kType) ? e0 + e1 : e0);
    p18[1] = RoundKind(kType) ? p18[0] : Power9(e1);
    p18[2] = Power9(eta[2] * eta[2]);
    for (int i = 0; i < 3; ++i) sigma[i] = p18[i] * eta[i];
  }
  for (int i = 0; i < 3; ++i) m[i] = sigma[i] * ia[i];

  const Lanes length_square = Max(u[0] * u[0] + u[1] * u[1] + u[2] * u[2], tiny);
  const Lanes inverse_length = InverseSqrt(length_square);
  const Lanes length = length_square * inverse_length;
  out.e = largest > tiny ? length - length * inverse_s : Splat(-g.size.minCoeff());

  // Normal of the deformed surface at x = u / s.
  Lanes x[3], b[3];
  for (int i = 0; i < 3; ++i) x[i] = u[i] * inverse_s;
  Lanes h0{}, h1{}, rho{}, c{}, sn{};
  if constexpr (kTapered) {
    h0 = 1.0 + k0 * x[2];
    h1 = 1.0 + k1 * x[2];
    b[0] = h1 * m[0];
    b[1] = h0 * m[1];
    b[2] = h0 * h1 * m[2] - h1 * k0 * x[0] * m[0] - h0 * k1 * x[1] * m[1];
  } else if constexpr (kCurved) {
    SineCosine(k0 * x[2], sn, c);
    rho = 1.0 - k0 * x[0];
    b[0] = rho * c * m[0] + sn * m[2];
    b[1] = rho * m[1];
    b[2] = c * m[2] - rho * sn * m[0];
  } else {
    for (int i = 0; i < 3; ++i) b[i] = m[i];
  }
  const Lanes inverse_b = InverseSqrt(Max(b[0] * b[0] + b[1] * b[1] + b[2] * b[2], tiny));
  Lanes n[3];
  for (int i = 0; i < 3; ++i) {
    n[i] = b[i] * inverse_b;
    out.difference[i] = n[i] - nd[i];
  }
  if constexpr (!kDerivatives) return;

  // Derivatives of e and b by u and by the sizes. H = second derivative of the gauge by u.
  Lanes hessian[3][3];
  for (int i = 0; i < 3; ++i) {
    for (int j = i; j < 3; ++j) {
      Lanes h;
      if constexpr (kEllipsoid) {
        h = -eta[i] * eta[j];
        if (i == j) h += 1.0;
      } else {
        h = -19.0 * sigma[i] * sigma[j];
        if (RoundKind(kType) && j < 2) {
          const Lanes radius_square = Max(eta[0] * eta[0] + eta[1] * eta[1], tiny);
          h += 18.0 * (p18[0] / radius_square) * eta[i] * eta[j];
          if (i == j) h += p18[0];
        } else if (i == j) {
          h += 19.0 * p18[i];
        }
      }
      hessian[i][j] = hessian[j][i] = h * (inverse_s * (ia[i] * ia[j]));
    }
  }
  const Lanes along = 1.0 - inverse_s, across = length * inverse_s * inverse_s;
  // bx_k = db/dx_k, and their sum along x.
  Lanes bx[3][3], bxx[3] = {Lanes{}, Lanes{}, Lanes{}};
  if constexpr (kTapered) {
    bx[0][0] = bx[0][1] = Lanes{};
    bx[0][2] = -k0 * h1 * m[0];
    bx[1][0] = bx[1][1] = Lanes{};
    bx[1][2] = -k1 * h0 * m[1];
    bx[2][0] = k1 * m[0];
    bx[2][1] = k0 * m[1];
    bx[2][2] = (k0 * h1 + k1 * h0) * m[2] - (k0 * k1) * (x[0] * m[0] + x[1] * m[1]);
  } else if constexpr (kCurved) {
    bx[0][0] = -k0 * c * m[0];
    bx[0][1] = -k0 * m[1];
    bx[0][2] = k0 * sn * m[0];
    bx[1][0] = bx[1][1] = bx[1][2] = Lanes{};
    bx[2][0] = k0 * (c * m[2] - rho * sn * m[0]);
    bx[2][1] = Lanes{};
    bx[2][2] = -k0 * (sn * m[2] + rho * c * m[0]);
  }
  if constexpr (kTapered || kCurved) {
    for (int i = 0; i < 3; ++i) bxx[i] = bx[0][i] * x[0] + bx[1][i] * x[1] + bx[2][i] * x[2];
  }
  // B times a vector.
  const auto carry = [&](const Lanes(&v)[3], Lanes(&to)[3]) __attribute__((always_inline)) {
    if constexpr (kTapered) {
      to[0] = h1 * v[0];
      to[1] = h0 * v[1];
      to[2] = h0 * h1 * v[2] - h1 * k0 * x[0] * v[0] - h0 * k1 * x[1] * v[1];
    } else if constexpr (kCurved) {
      to[0] = rho * c * v[0] + sn * v[2];
      to[1] = rho * v[1];
      to[2] = c * v[2] - rho * sn * v[0];
    } else {
      for (int i = 0; i < 3; ++i) to[i] = v[i];
    }
  };
  Column by_u[3], by_size[3];
  for (int j = 0; j < 3; ++j) {
    const Lanes column[3] = {hessian[0][j], hessian[1][j], hessian[2][j]};
    Lanes bh[3];
    carry(column, bh);
    by_u[j].e = u[j] * inverse_length * along + across * m[j];
    by_size[j].e = -across * y[j] * m[j];
    Lanes axis[3] = {Lanes{}, Lanes{}, Lanes{}}, ba[3];
    axis[j] = m[j] * ia[j];
    carry(axis, ba);
    for (int i = 0; i < 3; ++i) {
      by_u[j].n[i] = bh[i];
      by_size[j].n[i] = -y[j] * bh[i] - ba[i];
      if constexpr (kTapered || kCurved) {
        by_u[j].n[i] += (bx[j][i] - bxx[i] * m[j]) * inverse_s;
        by_size[j].n[i] += bxx[i] * inverse_s * y[j] * m[j];
      }
    }
  }

  // By the deformation, and from u to the datum d.
  Column by_deformation[2];
  Column by_d[3] = {by_u[0], by_u[1], by_u[2]};
  if constexpr (kTapered) {
    const double k[2] = {k0, k1};
    by_deformation[0].n[0] = Lanes{};
    by_deformation[0].n[1] = x[2] * m[1];
    by_deformation[0].n[2] = x[2] * h1 * m[2] - h1 * x[0] * m[0] - x[2] * k1 * x[1] * m[1];
    by_deformation[1].n[0] = x[2] * m[0];
    by_deformation[1].n[1] = Lanes{};
    by_deformation[1].n[2] = x[2] * h0 * m[2] - h0 * x[1] * m[1] - x[2] * k0 * x[0] * m[0];
    for (int i = 0; i < 2; ++i) {
      by_deformation[i].e = Lanes{};
      AddScaled(by_deformation[i], -u[i] * d[2] * inverse_factor[i] * guarded[i], by_u[i]);   // by k = K / az
      by_d[i].e = by_u[i].e * inverse_factor[i];
      for (int l = 0; l < 3; ++l) by_d[i].n[l] = by_u[i].n[l] * inverse_factor[i];
      AddScaled(by_d[2], -k[i] * u[i] * inverse_factor[i] * guarded[i], by_u[i]);
      AddScaled(by_size[2], Splat(-k[i] * ia[2]), by_deformation[i]);
    }
    for (int i = 0; i < 2; ++i) {
      by_deformation[i].e *= ia[2];
      for (int l = 0; l < 3; ++l) by_deformation[i].n[l] *= ia[2];
    }
  }
  if constexpr (kCurved) {
    const Lanes turn[3] = {c * m[2] - rho * sn * m[0], Lanes{}, -sn * m[2] - rho * c * m[0]};
    const Lanes shrink[3] = {-c * m[0], -m[1], sn * m[0]};
    by_deformation[0].e = Lanes{};
    for (int i = 0; i < 3; ++i) by_deformation[0].n[i] = x[0] * shrink[i] + x[2] * turn[i];
    const Lanes inverse_r = 1.0 / bend_r;
    const Lanes r_by_k = (k0 * d[2] * d[2] - d[0] * (1.0 - k0 * d[0])) * inverse_r;
    const Lanes x_by_k = -(d[0] * d[0] + d[2] * d[2] + u[0] * r_by_k) / (1.0 + bend_r);
    const Lanes z_by_k = k0 > 1e-7 ? (d[2] * inverse_r * inverse_r - u[2]) / k0 : d[0] * d[2];
    AddScaled(by_deformation[0], x_by_k, by_u[0]);
    AddScaled(by_deformation[0], z_by_k, by_u[2]);
    const auto turned = [&](Column& to, Lanes from_x, Lanes from_z) __attribute__((always_inline)) {
      to.e = from_x * by_u[0].e + from_z * by_u[2].e;
      for (int i = 0; i < 3; ++i) to.n[i] = from_x * by_u[0].n[i] + from_z * by_u[2].n[i];
    };
    turned(by_d[0], bend_c, bend_s * inverse_r);
    turned(by_d[2], -bend_s, bend_c * inverse_r);
  }

  // From b to n_m = b / |b|.
  const auto normalise = [&](Column& column) __attribute__((always_inline)) {
    const Lanes dot = n[0] * column.n[0] + n[1] * column.n[1] + n[2] * column.n[2];
    for (int i = 0; i < 3; ++i) column.n[i] = (column.n[i] - n[i] * dot) * inverse_b;
  };
  for (int j = 0; j < 3; ++j) {
    normalise(by_d[j]);
    normalise(by_size[j]);
    out.column[6 + j] = by_size[j];
  }
  if constexpr (kTapered || kCurved) {
    for (int j = 0; j < (kTapered ? 2 : 1); ++j) {
      normalise(by_deformation[j]);
      out.column[9 + j] = by_deformation[j];
    }
  }
  // Moving G by tau moves d by -tau; turning it by w moves d by d x w and the datum's normal by n_d x w.
  for (int j = 0; j < 3; ++j) {
    const int k = (j + 1) % 3, l = (j + 2) % 3;
    Column& turn = out.column[j];
    turn.e = by_d[k].e * d[l] - by_d[l].e * d[k];
    for (int i = 0; i < 3; ++i) turn.n[i] = by_d[k].n[i] * d[l] - by_d[l].n[i] * d[k];
    turn.n[k] -= nd[l];
    turn.n[l] += nd[k];
    out.column[3 + j].e = -by_d[j].e;
    for (int i = 0; i < 3; ++i) out.column[3 + j].n[i] = -by_d[j].n[i];
  }
}

GEOND_LANES_INLINE double Sum(Lanes x) {
  return ((x[0] + x[1]) + (x[2] + x[3])) + ((x[4] + x[5]) + (x[6] + x[7]));
}

GEOND_LANES_INLINE Lanes Smooth(Lanes magnitude, double floor) {
  return magnitude > floor ? magnitude : 0.5 * (magnitude * magnitude / (floor + 1e-280) + floor);
}

template <GeonType kType>
GEOND_LANES_INLINE MisfitSums SumBlocks(const GeonState& g, const LanePoints& points, double floor) {
  Lanes weight{}, distance{}, smooth{}, normal{};
  BlockResult block;
  for (int at = 0; at < points.padded(); at += kLanes) {
    EvaluateBlock<kType, false>(g, points, at, block);
    const Lanes w = Load(&points.weight[at]);
    const Lanes* r = block.difference;
    const Lanes magnitude = Abs(block.e);
    weight += w;
    distance += w * magnitude;
    smooth += w * Smooth(magnitude, floor);
    normal += w * (r[0] * r[0] + r[1] * r[1] + r[2] * r[2]);
  }
  return {Sum(weight), Sum(distance), Sum(smooth), Sum(normal)};
}

template <GeonType kType>
GEOND_LANES_INLINE void PointBlocks(const GeonState& g, const LanePoints& points, double* e, double* normal) {
  BlockResult block;
  for (int at = 0; at < points.padded(); at += kLanes) {
    EvaluateBlock<kType, false>(g, points, at, block);
    const Lanes* r = block.difference;
    const Lanes square = r[0] * r[0] + r[1] * r[1] + r[2] * r[2];
    __builtin_memcpy(e + at, &block.e, sizeof block.e);
    __builtin_memcpy(normal + at, &square, sizeof square);
  }
}

template <GeonType kType>
GEOND_LANES_INLINE void DifferentiateBlocks(const GeonState& g, const LanePoints& points, double normal_weight,
                                            double floor, MisfitDerivatives& out) {
  constexpr int n = CountOf(kType);
  Lanes weight{}, distance{}, smooth{}, normal{};
  Lanes hessian[n * (n + 1) / 2] = {}, by_distance[n] = {}, by_normal[n] = {};
  BlockResult block;
  for (int at = 0; at < points.padded(); at += kLanes) {
    EvaluateBlock<kType, true>(g, points, at, block);
    const Lanes w = Load(&points.weight[at]);
    const Lanes* r = block.difference;
    const Lanes magnitude = Abs(block.e);
    weight += w;
    distance += w * magnitude;
    smooth += w * Smooth(magnitude, floor);
    normal += w * (r[0] * r[0] + r[1] * r[1] + r[2] * r[2]);
    const Lanes we = w / Max(magnitude, Splat(floor)), wn = w * normal_weight;
    int at_pair = 0;
    for (int j = 0; j < n; ++j) {
      const Column& a = block.column[j];
      const Lanes ae = we * a.e, a0 = wn * a.n[0], a1 = wn * a.n[1], a2 = wn * a.n[2];
      by_distance[j] += ae * block.e;
      by_normal[j] += w * (a.n[0] * r[0] + a.n[1] * r[1] + a.n[2] * r[2]);
      for (int k = 0; k <= j; ++k) {
        const Column& b = block.column[k];
        hessian[at_pair++] += (ae * b.e + a0 * b.n[0]) + (a1 * b.n[1] + a2 * b.n[2]);
      }
    }
  }
  out.sums = {Sum(weight), Sum(distance), Sum(smooth), Sum(normal)};
  int at_pair = 0;
  for (int j = 0; j < n; ++j) {
    out.distance_gradient[j] = Sum(by_distance[j]);
    out.normal_gradient[j] = Sum(by_normal[j]);
    for (int k = 0; k <= j; ++k) out.hessian(j, k) = out.hessian(k, j) = Sum(hessian[at_pair++]);
  }
}

}  // namespace geond::lanes
