// SPDX-License-Identifier: Apache-2.0
#include "core/charge/interactions.h"

#include <algorithm>
#include <cstdlib>
#include <limits>
#include <utility>

#include "core/base/parallel.h"

namespace geond::charge {
namespace {

using Pair = std::pair<int, int>;  // target, source

class Traversal {
 public:
  Traversal(const Tree& tree, const FarRule& rule, const std::vector<int>& leaf_of_cell)
      : tree_(tree), rule_(rule), leaf_of_cell_(leaf_of_cell) {}

  // Pairs whose target is `last` cells or beyond are put aside in `later`.
  void Visit(int target, int source, int last = std::numeric_limits<int>::max()) {
    if (target >= last) {
      later.emplace_back(target, source);
      return;
    }
    const Cell &A = tree_.cells[target], &B = tree_.cells[source];
    const bool enough = static_cast<std::ptrdiff_t>(A.count()) * B.count() >= rule_.least_work;
    if (enough && Converges(A, B) && std::abs(A.level - B.level) <= kMostLevelsApart) {
      far.emplace_back(target, source);
    } else if (A.is_leaf() && B.is_leaf()) {
      near.emplace_back(leaf_of_cell_[target], leaf_of_cell_[source]);
    } else if (!A.is_leaf() && !B.is_leaf() && A.level == B.level) {
      for (int a = A.first_child; a < A.first_child + A.child_count; ++a) {
        for (int b = B.first_child; b < B.first_child + B.child_count; ++b) Visit(a, b, last);
      }
    } else if (B.is_leaf() || (!A.is_leaf() && A.level < B.level)) {
      for (int a = A.first_child; a < A.first_child + A.child_count; ++a) Visit(a, source, last);
    } else {
      for (int b = B.first_child; b < B.first_child + B.child_count; ++b) Visit(target, b, last);
    }
  }

  std::vector<Pair> near, far, later;

 private:
  // radius of one / (distance - radius of the other) <= steepest, both ways.
  bool Converges(const Cell& A, const Cell& B) const {
    const double a = A.centroid_radius, b = B.triangle_radius, t = rule_.steepest;
    const double needed = std::max(b / t + a, a / t + b);
    return needed * needed < (A.centre - B.centre).squaredNorm();
  }

  const Tree& tree_;
  FarRule rule_;
  const std::vector<int>& leaf_of_cell_;
};

std::vector<int> LeafOfCell(const Tree& tree) {
  std::vector<int> leaf_of_cell(tree.cells.size(), -1);
  for (std::size_t i = 0; i < tree.leaves.size(); ++i) leaf_of_cell[tree.leaves[i]] = static_cast<int>(i);
  return leaf_of_cell;
}

}  // namespace

Interactions FindInteractions(const Tree& tree, const FarRule& rule, int threads) {
  // From the root down to a level of enough cells to share out; then each of these as a target by itself.
  constexpr int kEnough = 64;
  const std::vector<int> leaf_of_cell = LeafOfCell(tree);
  std::size_t level = 0;
  while (level + 2 < tree.level_begin.size() && tree.level_begin[level + 1] - tree.level_begin[level] < kEnough)
    ++level;
  const int first = tree.level_begin[level], count = tree.level_begin[level + 1] - first;
  Traversal top(tree, rule, leaf_of_cell);
  top.Visit(0, 0, first);
  std::vector<std::vector<Pair>> shares(count);
  for (const Pair& pair : top.later) shares[pair.first - first].push_back(pair);
  std::vector<std::vector<Pair>> near(count), far(count);
  ParallelFor(count, threads, 1, [&](std::ptrdiff_t c) {
    Traversal below(tree, rule, leaf_of_cell);
    for (const auto& [target, source] : shares[c]) below.Visit(target, source);
    near[c] = std::move(below.near), far[c] = std::move(below.far);
  });
  for (int c = 0; c < count; ++c) {
    top.near.insert(top.near.end(), near[c].begin(), near[c].end());
    top.far.insert(top.far.end(), far[c].begin(), far[c].end());
  }
  Interactions interactions;
  interactions.near = SortByTarget(top.near, tree.leaves.size(), threads);
  interactions.far = SortByTarget(top.far, tree.cells.size(), threads);
  return interactions;
}

}  // namespace geond::charge
