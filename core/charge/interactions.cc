// SPDX-License-Identifier: Apache-2.0
#include "core/charge/interactions.h"

#include <algorithm>
#include <cstdlib>
#include <utility>

namespace geond::charge {
namespace {

using Pair = std::pair<int, int>;  // target, source

class Traversal {
 public:
  Traversal(const Tree& tree, const FarRule& rule) : tree_(tree), rule_(rule), leaf_of_cell_(tree.cells.size(), -1) {
    for (std::size_t i = 0; i < tree.leaves.size(); ++i) leaf_of_cell_[tree.leaves[i]] = static_cast<int>(i);
  }

  void Visit(int target, int source) {
    const Cell &A = tree_.cells[target], &B = tree_.cells[source];
    const bool enough = static_cast<std::ptrdiff_t>(A.count()) * B.count() >= rule_.least_work;
    if (enough && Converges(A, B) && std::abs(A.level - B.level) <= kMostLevelsApart) {
      far.emplace_back(target, source);
    } else if (A.is_leaf() && B.is_leaf()) {
      near.emplace_back(leaf_of_cell_[target], leaf_of_cell_[source]);
    } else if (!A.is_leaf() && !B.is_leaf() && A.level == B.level) {
      for (int a = A.first_child; a < A.first_child + A.child_count; ++a) {
        for (int b = B.first_child; b < B.first_child + B.child_count; ++b) Visit(a, b);
      }
    } else if (B.is_leaf() || (!A.is_leaf() && A.level < B.level)) {
      for (int a = A.first_child; a < A.first_child + A.child_count; ++a) Visit(a, source);
    } else {
      for (int b = B.first_child; b < B.first_child + B.child_count; ++b) Visit(target, b);
    }
  }

  std::vector<Pair> near, far;

 private:
  // radius of one / (distance - radius of the other) <= steepest, both ways.
  bool Converges(const Cell& A, const Cell& B) const {
    const double a = A.centroid_radius, b = B.triangle_radius, t = rule_.steepest;
    const double needed = std::max(b / t + a, a / t + b);
    return needed * needed < (A.centre - B.centre).squaredNorm();
  }

  const Tree& tree_;
  FarRule rule_;
  std::vector<int> leaf_of_cell_;
};

}  // namespace

Interactions FindInteractions(const Tree& tree, const FarRule& rule) {
  Traversal traversal(tree, rule);
  traversal.Visit(0, 0);
  Interactions interactions;
  interactions.near = SortByTarget(traversal.near, tree.leaves.size());
  interactions.far = SortByTarget(traversal.far, tree.cells.size());
  return interactions;
}

}  // namespace geond::charge
