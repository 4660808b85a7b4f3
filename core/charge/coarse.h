// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include <Eigen/LU>

#include "core/charge/interactions.h"
#include "core/charge/near_field.h"
#include "core/charge/tree.h"

namespace geond::charge {

// What no local solve can know: how charge spreads over the whole body. A few hundred cells of the tree, each with an
// even density, are solved together; the local solves then say only how the density varies within each of them.
class CoarseInverse {
 public:
  // The cells hold at most `largest` triangles each. Near pairs count by their held integrals, far ones as points.
  template <typename Real>
  CoarseInverse(const Panels& panels, const Tree& tree, const Interactions& interactions, const NearField<Real>& near,
                int largest, int threads, const Kernels& kernels);

  // y is an approximate solution of A y = x by local solves, in the tree's order: its mean in each cell is made that of
  // the coarse solution.
  void Correct(std::span<const double> x, std::span<double> y) const;

  int cells() const { return static_cast<int>(begin_.size()) - 1; }

 private:
  int threads_;
  std::vector<int> begin_;     // cell c has the triangles from begin_[c] to begin_[c + 1]
  std::vector<double> share_;  // of each triangle in its cell's area
  Eigen::PartialPivLU<Eigen::MatrixXf> matrix_;
};

}  // namespace geond::charge
