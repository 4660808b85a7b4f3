// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/charge/kernels.h"
#include "core/charge/quadrature.h"
#include "core/charge/source_lists.h"
#include "core/charge/tree.h"

namespace geond::charge {

// The degree of the expansions between two cells: the least at which what is left out leaps, between neighbours in the
// target, by about `leap` of the size of a triangle there, for a density of one. The density answers a leap of the
// potential by the leap over the triangles' size; so large cells, which bear more charge, and cells of fine triangles
// get more.
struct OrderRule {
  int lowest = 2, highest = 10;
  double leap = 0.0006;
};

// The potential of the far pairs by multipoles: up the tree, across, and down again (Greengard and Rokhlin 1987). The
// step across is a product of a small matrix with as many vectors as there are pairs of cells at that distance, taken
// together; reflections leave one matrix for eight distances. Triangles are counted in the tree's order.
template <typename Real>
class FarField {
 public:
  // `rule` says which points stand for a triangle in the multipoles.
  FarField(const TriangleMesh& mesh, const Panels& panels, const Tree& tree, const SourceLists& far,
           const OrderRule& order, std::span<const RulePoint> rule, int threads, const Kernels& kernels);

  // Takes in the densities x; AddPotential then has their far potential.
  void Spread(std::span<const Real> x);

  // potential[i] += the far potential at the triangles i = 0, 1, ... of a leaf; potential is padded.
  void AddPotential(int leaf, Real* potential) const;

  std::size_t bytes() const;
  std::size_t matrices() const { return matrices_.size(); }
  std::ptrdiff_t multiplications() const;  // of all the matrices by their vectors

 private:
  struct Matrix {
    std::size_t begin;  // in across_
    int stride;
  };
  Real* VectorOf(std::vector<Real>& vectors, int cell) {
    return &vectors[static_cast<std::size_t>(vector_begin_[cell]) * kPadding];
  }
  // One matrix and the pairs it serves, one after another in pairs_.
  struct Batch {
    int matrix, order;
    std::size_t begin, end;
  };
  void MakeBatches(const SourceLists& far, const OrderRule& rule);
  void PlaceVectors();
  void MakeShifts();
  void MakeLeaves(const TriangleMesh& mesh, const Panels& panels, std::span<const RulePoint> rule);
  void Gather(std::span<const Real> x);
  void Across();
  void Scatter();

  const Tree& tree_;
  const Kernels& kernels_;
  int threads_;
  int stride_ = 0;  // of the matrices that shift

  // Of each leaf, column-major: its multipoles of its densities, rows padded; and its potentials of its local
  // expansion.
  std::vector<std::size_t> gather_begin_, evaluate_begin_;
  std::vector<Real> gather_, evaluate_;

  std::array<std::vector<Real>, 8> up_, down_;  // by the child's octant
  std::vector<Real> across_;                    // all matrices, one after another
  std::vector<Matrix> matrices_;
  std::array<std::vector<Real>, 8> signs_;  // by reflection
  std::vector<CellPair> pairs_;
  std::vector<std::vector<Batch>> batches_;  // by group of targets; groups are served side by side
  std::vector<int> group_cells_;             // cells of group g: from group_cells_[g] to group_cells_[g + 1]

  std::vector<int> order_;         // of each cell's expansions; -1 where none are needed
  std::vector<int> vector_begin_;  // of each cell's, in steps of kPadding
  std::vector<Real> multipoles_, locals_;
};

extern template class FarField<float>;
extern template class FarField<double>;

}  // namespace geond::charge
