// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "core/base/large_array.h"
#include "core/charge/kernels.h"
#include "core/charge/source_lists.h"
#include "core/charge/tree.h"

namespace geond::charge {

// How the integral over a near triangle is taken, by distance in diameters: exactly, triangle by triangle; then, leaf
// by leaf, by seven points, by three, and by the centroid alone.
struct NearRule {
  double exact_within = 1.2;
  double seven_points_within = 1.0;
  double three_points_within = 4.0;
};

// The matrix of the near pairs, held: for each leaf the columns of all its near triangles, one after another without
// gaps. Triangles are counted in the tree's order.
template <typename Real>
class NearField {
 public:
  NearField(const TriangleMesh& mesh, const Panels& panels, const Tree& tree, const SourceLists& near,
            const NearRule& rule, int threads, const Kernels& kernels);

  // potential[i] += sum over the near triangles of leaf `leaf`, for its triangles i = 0, 1, ...
  void AddPotential(int leaf, std::span<const Real> x, Real* potential) const;

  // The columns of one near pair of leaves; and those of leaf `source` in the rows of leaf `target`, null if they are
  // far.
  const Real* Block(std::size_t pair) const { return &values_[block_begin_[pair]]; }
  const Real* Block(int target, int source) const;

  std::size_t pairs() const { return value_count_; }
  std::size_t exact_pairs() const { return exact_pairs_; }  // whose integral was taken exactly
  // Whether somewhere two triangles face each other over less than 0.006 of their size: single precision is then not
  // enough.
  bool thin_gap() const { return thin_gap_; }
  std::size_t bytes() const { return value_count_ * sizeof(Real) + block_begin_.size() * sizeof(std::size_t); }

 private:
  const Tree& tree_;
  const SourceLists& near_;
  const Kernels& kernels_;
  std::vector<std::size_t> block_begin_;  // of each pair of `near`, into values_
  std::size_t value_count_ = 0, exact_pairs_ = 0;
  bool thin_gap_ = false;
  LargeArray<Real> values_;
};

extern template class NearField<float>;
extern template class NearField<double>;

}  // namespace geond::charge
