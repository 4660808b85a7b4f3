// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include <Eigen/Core>

namespace geond::charge {

// Solid harmonics and their translations: how the potential of many charges is carried by a few numbers.
//
// Regular U_n^m = (-1)^m r^n P_n^m(cos t) e^(i m f)/(n + m)! and irregular V_n^m = (-1)^m (n - m)! P_n^m e^(i m f)/r^(n+1)
// (Dehnen, Comput. Astrophys. Cosmol. 1 (2014) 1). With them, for |y| < |x|,
//   1/|x - y| = sum over n, m of conj(U_n^m(y)) V_n^m(x),
//   U_n^m(x + y) = sum U_k^l(x) U_(n-k)^(m-l)(y),     V_n^m(x + y) = sum (-1)^k conj(U_k^l(y)) V_(n+k)^(m+l)(x).
// As F_n^(-m) = (-1)^m conj(F_n^m), the real and imaginary parts for m >= 0 say everything. We keep them as (p + 1)^2 real
// numbers, those of degree n from place n^2 on: Re m = 0, Re 1, Im 1, Re 2, Im 2, ...
//
// A multipole vector M = sum q U(y) and a local vector L with potential sum_j U_j(y) L_j are taken in lengths of the half
// side of their cell, so that one matrix serves all levels of the tree.
constexpr int CoefficientCount(int order) { return (order + 1) * (order + 1); }
constexpr int CoefficientIndex(int n, int m, bool imaginary) { return n * n + (m == 0 ? 0 : 2 * m - (imaginary ? 0 : 1)); }

// U(y) up to `order`.
std::vector<double> RegularHarmonics(const Eigen::Vector3d& y, int order);

// The matrix T with U(scale * y + shift) = T U(y). Moves a multipole to a parent's centre: M_parent = T M_child with
// scale 1/2; and a local expansion to a child's: L_child = T^T L_parent.
Eigen::MatrixXd ShiftMatrix(const Eigen::Vector3d& shift, double scale, int order);

// The matrix K with L = K M for a source cell at -distance from the target cell. Lengths in half sides of the target; the
// source's half side is `source_scale` of them. |distance| must exceed the sum of both cells' radii. Between degrees whose
// sum is beyond `most_degrees` it is zero.
Eigen::MatrixXd MultipoleToLocalMatrix(const Eigen::Vector3d& distance, double source_scale, int order, int most_degrees);

// The signs s with K(reflected distance) = diag(s) K(distance) diag(s), for a reflection in x (bit 0), y (1) and z (2).
std::vector<double> ReflectionSigns(int axes, int order);

}  // namespace geond::charge
