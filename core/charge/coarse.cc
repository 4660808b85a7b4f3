// SPDX-License-Identifier: Apache-2.0
#include "core/charge/coarse.h"

#include <algorithm>
#include <utility>

#include "core/base/parallel.h"

namespace geond::charge {
namespace {

// Area and centre of area of any run of triangles in the tree's order, from sums up to each.
class Masses {
 public:
  Masses(const Panels& panels, const Tree& tree) : sums_(tree.order.size() + 1, Eigen::Vector4d::Zero()) {
    for (std::size_t i = 0; i < tree.order.size(); ++i) {
      const int t = tree.order[i];
      sums_[i + 1] = sums_[i] + panels.area[t] * Eigen::Vector4d(panels.x[t], panels.y[t], panels.z[t], 1.0);
    }
  }
  double Area(int begin, int end) const { return sums_[end][3] - sums_[begin][3]; }
  Eigen::Vector3d Centre(int begin, int end) const { return (sums_[end] - sums_[begin]).head<3>() / Area(begin, end); }

 private:
  std::vector<Eigen::Vector4d> sums_;
};

// A run of triangles that lies within one coarse cell.
struct Piece {
  int coarse;
  double area;
  Eigen::Vector3d centre;
};

}  // namespace

template <typename Real>
CoarseInverse::CoarseInverse(const Panels& panels, const Tree& tree, const Interactions& interactions,
                             const NearField<Real>& near, int largest, int threads, const Kernels& kernels)
    : threads_(threads), share_(tree.order.size()) {
  const int n = static_cast<int>(tree.order.size());
  for (const Cell& cell : tree.cells) {
    const auto small = [&](const Cell& c) { return c.is_leaf() || c.count() <= largest; };
    if (small(cell) && (cell.parent < 0 || !small(tree.cells[cell.parent]))) begin_.push_back(cell.begin);
  }
  std::sort(begin_.begin(), begin_.end());
  begin_.push_back(n);
  const Masses masses(panels, tree);
  std::vector<double> area(cells());
  for (int c = 0; c < cells(); ++c) {
    area[c] = masses.Area(begin_[c], begin_[c + 1]);
    for (int i = begin_[c]; i < begin_[c + 1]; ++i) share_[i] = panels.area[tree.order[i]] / area[c];
  }

  // The mean potential on one cell of the unit density on another.
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> A(cells(), cells());
  A.setZero();
  const auto coarse_of = [&](int triangle) {
    return static_cast<int>(std::upper_bound(begin_.begin(), begin_.end(), triangle) - begin_.begin()) - 1;
  };
  int most = 0;  // triangles of a leaf
  for (int leaf : tree.leaves) most = std::max(most, tree.cells[leaf].count());
  const std::vector<Real> ones(most, Real(1));
  ParallelFor(cells(), threads, 1, [&](std::ptrdiff_t I) {
    std::vector<Real> potential(most);
    const auto by_begin = [&](int leaf, int place) { return tree.cells[leaf].begin < place; };
    auto leaf = std::lower_bound(tree.leaves.begin(), tree.leaves.end(), begin_[I], by_begin) - tree.leaves.begin();
    for (; leaf < std::ssize(tree.leaves) && tree.cells[tree.leaves[leaf]].begin < begin_[I + 1]; ++leaf) {
      const Cell& target = tree.cells[tree.leaves[leaf]];
      for (std::size_t pair = interactions.near.begin[leaf]; pair < interactions.near.begin[leaf + 1]; ++pair) {
        const Cell& source = tree.cells[tree.leaves[interactions.near.source[pair]]];
        std::fill(potential.begin(), potential.begin() + target.count(), Real(0));
        LoopsOf<Real>(kernels).multiply(near.Block(pair), target.count(), source.count(), ones.data(),
                                        potential.data());
        double sum = 0.0;
        for (int i = 0; i < target.count(); ++i) sum += share_[target.begin + i] * potential[i];
        A(I, coarse_of(source.begin)) += sum;
      }
    }
  });
  // Cells larger than the coarse ones are taken apart.
  const auto pieces_of = [&](const Cell& cell, std::vector<Piece>& pieces) {
    pieces.clear();
    for (int c = coarse_of(cell.begin); c < cells() && begin_[c] < cell.end; ++c) {
      const int begin = std::max(cell.begin, begin_[c]), end = std::min(cell.end, begin_[c + 1]);
      pieces.push_back({c, masses.Area(begin, end), masses.Centre(begin, end)});
    }
  };
  std::vector<std::vector<Piece>> pieces(tree.cells.size());
  ParallelFor(std::ssize(pieces), threads, 256, [&](std::ptrdiff_t c) { pieces_of(tree.cells[c], pieces[c]); });
  for (std::size_t t = 0; t < tree.cells.size(); ++t) {
    for (std::size_t pair = interactions.far.begin[t]; pair < interactions.far.begin[t + 1]; ++pair) {
      for (const Piece& I : pieces[t]) {
        for (const Piece& J : pieces[interactions.far.source[pair]]) {
          A(I.coarse, J.coarse) += I.area / area[I.coarse] * J.area / (J.centre - I.centre).norm();
        }
      }
    }
  }
  matrix_.compute(A.cast<float>());
}

void CoarseInverse::Correct(std::span<const double> x, std::span<double> y) const {
  const auto mean = [&](int c, std::span<const double> values) {
    double sum = 0.0;
    for (int i = begin_[c]; i < begin_[c + 1]; ++i) sum += share_[i] * values[i];
    return sum;
  };
  Eigen::VectorXf potential(cells());
  ParallelFor(cells(), threads_, 16,
              [&](std::ptrdiff_t c) { potential[c] = static_cast<float>(mean(static_cast<int>(c), x)); });
  const Eigen::VectorXf density = matrix_.solve(potential);
  if (!density.allFinite()) return;
  ParallelFor(cells(), threads_, 16, [&](std::ptrdiff_t c) {
    const double lacking = density[c] - mean(static_cast<int>(c), y);
    for (int i = begin_[c]; i < begin_[c + 1]; ++i) y[i] += lacking;
  });
}

template CoarseInverse::CoarseInverse(const Panels&, const Tree&, const Interactions&, const NearField<float>&, int,
                                      int, const Kernels&);
template CoarseInverse::CoarseInverse(const Panels&, const Tree&, const Interactions&, const NearField<double>&, int,
                                      int, const Kernels&);

}  // namespace geond::charge
