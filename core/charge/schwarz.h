// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/base/large_array.h"
#include "core/charge/kernels.h"
#include "core/charge/near_field.h"
#include "core/charge/source_lists.h"
#include "core/charge/tree.h"

namespace geond::charge {

// An approximate inverse: each leaf is solved with a halo of the triangles around it, as if nothing else were charged,
// and keeps the part of the answer that is its own (restricted additive Schwarz; Cai and Sarkis 1999). The local
// inverses are held, in single precision.
class SchwarzInverse {
 public:
  // Takes the entries from the near field; a leaf's halo has up to `halo` triangles.
  template <typename Real>
  SchwarzInverse(const Panels& panels, const Tree& tree, const SourceLists& near, const NearField<Real>& matrix,
                 int halo, int threads, const Kernels& kernels);

  // y = M x, in the tree's order.
  void Apply(std::span<const double> x, std::span<double> y) const;

  std::size_t bytes() const { return row_begin_.back() * sizeof(float) + members_.size() * sizeof(int); }
  int plain_leaves() const { return plain_leaves_; }  // that went without a halo, dividing by the diagonal

 private:
  const Tree& tree_;
  const Kernels& kernels_;
  int threads_;
  int plain_leaves_ = 0;
  std::vector<std::size_t> member_begin_;  // of each leaf
  std::vector<int> members_;               // places in the tree's order, the halo's first
  std::vector<std::size_t> row_begin_;
  LargeArray<float> rows_;  // of each leaf: own triangles by members, column-major
};

}  // namespace geond::charge
