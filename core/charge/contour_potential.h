// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <complex>
#include <cstddef>
#include <span>
#include <stop_token>
#include <vector>

#include <Eigen/Core>

#include "core/charge/source_lists.h"

namespace geond::charge {

// A closed contour in the complex plane: segment k runs from vertex k to the next, the last to vertex 0.
struct Contour {
  std::vector<std::complex<double>> vertex;  // m
  std::vector<double> length;                // of each segment, m
  std::ptrdiff_t size() const { return static_cast<std::ptrdiff_t>(vertex.size()); }
  std::complex<double> end(std::ptrdiff_t k) const { return vertex[k + 1 == size() ? 0 : k + 1]; }
  std::complex<double> middle(std::ptrdiff_t k) const { return 0.5 * (vertex[k] + end(k)); }
};

// -2 times the mean of ln|z - w| over the points w of segment k, exact: the potential at z of unit charge there.
double SegmentPotential(const Contour& contour, std::ptrdiff_t k, std::complex<double> z);

// The potential of charges on the segments at the middles of all segments, in time and memory proportional to their
// number: multipoles of the logarithm (Greengard and Rokhlin, J. Comput. Phys. 73 (1987) 325) over a binary tree that
// follows the contour. `order` + 1 terms are kept; cells are far when the sum of their radii is below 0.6 of their
// distance, so that a term adds less than 0.43 of the one before it.
class ContourPotential {
 public:
  // Keeps `contour`. Throws Cancelled.
  ContourPotential(const Contour& contour, int order, int threads, const std::stop_token& stop);

  // potential[i] = sum over k of charge[k] * SegmentPotential(k, middle of i).
  void Apply(std::span<const double> charge, std::span<double> potential) const;

  std::size_t bytes() const { return near_values_.size() * sizeof(double); }

 private:
  using Complex = std::complex<double>;
  struct Cell {
    std::ptrdiff_t begin, end;
    int parent = -1, child = -1;  // the first of two children; none: a leaf
    Complex centre = 0.0;
    double radius = 0.0;  // reach of the segments from the centre
    std::ptrdiff_t count() const { return end - begin; }
  };
  void MakeCells();
  void FindPairs();
  void MakeNear(const std::stop_token& stop);
  void Gather(std::span<const double> charge, std::vector<Complex>& multipoles) const;
  void ShiftUp(const Cell& from, const Complex* child, const Cell& to, Complex* parent) const;
  void Across(int target, const std::vector<Complex>& multipoles, Complex* local) const;
  void ShiftDown(const Cell& from, const Complex* parent, const Cell& to, Complex* child) const;

  const Contour& contour_;
  int order_, threads_;
  std::vector<Cell> cells_;
  std::vector<int> level_begin_;
  SourceLists near_, far_;
  std::vector<std::size_t> near_begin_;  // of each near pair's block, column-major, into near_values_
  std::vector<double> near_values_;
  Eigen::MatrixXd choose_;  // binomial coefficients
  Eigen::MatrixXd across_;  // (l + k - 1 over k - 1), the step across without its powers of the distance
};

}  // namespace geond::charge
