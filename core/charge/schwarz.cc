// SPDX-License-Identifier: Apache-2.0
#include "core/charge/schwarz.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstdint>
#include <numeric>

#include "core/base/parallel.h"

namespace geond::charge {
namespace {

// All centroids in the tree's order, seen from the first cell's centre, and the leaf each lies in.
struct Places {
  std::vector<float> x, y, z;
  std::vector<int> leaf;

  Places(const Panels& panels, const Tree& tree) {
    const std::size_t n = panels.size();
    const Eigen::Vector3d& origin = tree.cells[0].centre;
    x.resize(n), y.resize(n), z.resize(n), leaf.resize(n);
    for (std::size_t l = 0; l < tree.leaves.size(); ++l) {
      const Cell& cell = tree.cells[tree.leaves[l]];
      for (int i = cell.begin; i < cell.end; ++i) {
        const int t = tree.order[i];
        x[i] = static_cast<float>(panels.x[t] - origin.x());
        y[i] = static_cast<float>(panels.y[t] - origin.y());
        z[i] = static_cast<float>(panels.z[t] - origin.z());
        leaf[i] = static_cast<int>(l);
      }
    }
  }
};

// The `wanted` triangles of near leaves that lie nearest to the box around the leaf's own centroids, in order.
void ChooseHalo(int leaf, const Places& places, const Tree& tree, const SourceLists& near, int wanted,
                std::vector<std::uint64_t>& candidates, std::vector<int>& halo) {
  halo.clear();
  if (wanted <= 0) return;
  const Cell& own = tree.cells[tree.leaves[leaf]];
  const auto [left, right] = std::minmax_element(&places.x[own.begin], &places.x[own.begin] + own.count());
  const auto [front, back] = std::minmax_element(&places.y[own.begin], &places.y[own.begin] + own.count());
  const auto [low, high] = std::minmax_element(&places.z[own.begin], &places.z[own.begin] + own.count());
  candidates.clear();
  for (std::size_t pair = near.begin[leaf]; pair < near.begin[leaf + 1]; ++pair) {
    if (near.source[pair] == leaf) continue;
    const Cell& cell = tree.cells[tree.leaves[near.source[pair]]];
    for (int i = cell.begin; i < cell.end; ++i) {
      const float dx = std::max({*left - places.x[i], places.x[i] - *right, 0.0f});
      const float dy = std::max({*front - places.y[i], places.y[i] - *back, 0.0f});
      const float dz = std::max({*low - places.z[i], places.z[i] - *high, 0.0f});
      // The bits of numbers that are not negative are in the order of the numbers; the place decides between equals.
      const auto distance = std::bit_cast<std::uint32_t>(dx * dx + dy * dy + dz * dz);
      candidates.push_back(std::uint64_t{distance} << 32 | static_cast<std::uint32_t>(i));
    }
  }
  if (static_cast<int>(candidates.size()) > wanted) {
    std::nth_element(candidates.begin(), candidates.begin() + wanted, candidates.end());
    candidates.resize(wanted);
  }
  for (std::uint64_t candidate : candidates) halo.push_back(static_cast<int>(candidate & 0xffffffffu));
  std::sort(halo.begin(), halo.end());
}

// Entries between the members of a local problem: those that are near each other from the near field, the rest as if the
// charge sat at the centroid.
template <typename Real>
class LocalMatrix {
 public:
  LocalMatrix(const Panels& panels, const Tree& tree, const Places& places, const NearField<Real>& matrix,
              const Kernels& kernels)
      : panels_(panels), tree_(tree), places_(places), matrix_(matrix), kernels_(kernels) {}

  // Row k of M, `width` apart, has the column of member k.
  void Fill(std::span<const int> members, int width, float* M) {
    const int m = static_cast<int>(members.size());
    for (auto* values : {&x_, &y_, &z_}) values->assign(Padded(m), 0.0f);
    which_.resize(Padded(m));
    for (int i = 0; i < m; ++i) x_[i] = places_.x[members[i]], y_[i] = places_.y[members[i]], z_[i] = places_.z[members[i]];
    const auto& loops = kernels_.single_precision;
    constexpr float kNoShift[3] = {};
    for (int k = 0; k < m; ++k) {
      const int triangle = tree_.order[members[k]];
      float* const column = M + static_cast<std::ptrdiff_t>(k) * width;
      const float area = static_cast<float>(panels_.area[triangle]);
      loops.point_columns(m, x_.data(), y_.data(), z_.data(), kNoShift, 1, 1, &x_[k], &y_[k], &z_[k], &area, column);
      const float centre[3] = {x_[k], y_[k], z_[k]};
      const float reach = kLookedUp * static_cast<float>(panels_.diameter[triangle]);
      const int count = loops.within_reach(m, x_.data(), y_.data(), z_.data(), centre, reach * reach, which_.data());
      const int source = places_.leaf[members[k]];
      const Cell& source_cell = tree_.cells[tree_.leaves[source]];
      int last_target = -1;
      const Real* block = nullptr;
      for (int j = 0; j < count; ++j) {
        const int i = which_[j], target = places_.leaf[members[i]];
        const Cell& target_cell = tree_.cells[tree_.leaves[target]];
        if (target != last_target) block = matrix_.Block(target, source);
        last_target = target;
        if (!block) continue;
        const auto at = static_cast<std::ptrdiff_t>(members[k] - source_cell.begin) * target_cell.count();
        column[i] = static_cast<float>(block[at + members[i] - target_cell.begin]);
      }
    }
  }

 private:
  static constexpr float kLookedUp = 0.7f;  // diameters within which
  const Panels& panels_;
  const Tree& tree_;
  const Places& places_;
  const NearField<Real>& matrix_;
  const Kernels& kernels_;
  std::vector<float> x_, y_, z_;
  std::vector<int> which_;
};

}  // namespace

template <typename Real>
SchwarzInverse::SchwarzInverse(const Panels& panels, const Tree& tree, const SourceLists& near,
                               const NearField<Real>& matrix, int most, int threads, const Kernels& kernels)
    : tree_(tree), kernels_(kernels), threads_(threads) {
  const std::size_t leaves = tree.leaves.size();
  const Places places(panels, tree);
  // Each leaf has as many members as it can get, so that their places are known before they are chosen.
  member_begin_ = {0}, row_begin_ = {0};
  for (std::size_t leaf = 0; leaf < leaves; ++leaf) {
    const int own = tree.cells[tree.leaves[leaf]].count();
    int around = 0;
    for (std::size_t pair = near.begin[leaf]; pair < near.begin[leaf + 1]; ++pair) {
      around += tree.cells[tree.leaves[near.source[pair]]].count();
    }
    const int members = own > most ? 1 : std::min(most, around);
    member_begin_.push_back(member_begin_.back() + members);
    row_begin_.push_back(row_begin_.back() + static_cast<std::size_t>(members) * own);
  }
  members_.resize(member_begin_.back());
  rows_.resize(row_begin_.back() + kPadding);
  std::atomic<int> plain{0};
  constexpr std::ptrdiff_t kLeaves = 16;  // to a task
  ParallelFor((static_cast<std::ptrdiff_t>(leaves) + kLeaves - 1) / kLeaves, threads, 1, [&](std::ptrdiff_t task) {
    LocalMatrix<Real> local(panels, tree, places, matrix, kernels);
    std::vector<std::uint64_t> candidates;
    std::vector<int> halo;
    std::vector<float> M;
    const int last = static_cast<int>(std::min<std::ptrdiff_t>(leaves, (task + 1) * kLeaves));
    for (int leaf = static_cast<int>(task * kLeaves); leaf < last; ++leaf) {
      const Cell& cell = tree.cells[tree.leaves[leaf]];
      const int own = cell.count(), m = static_cast<int>(member_begin_[leaf + 1] - member_begin_[leaf]);
      const std::span members(&members_[member_begin_[leaf]], static_cast<std::size_t>(m));
      const std::span rows(&rows_[row_begin_[leaf]], static_cast<std::size_t>(m) * own);
      bool solved = own <= most;
      if (solved) {
        // Own triangles last: the elimination then meets their right-hand sides late.
        ChooseHalo(leaf, places, tree, near, m - own, candidates, halo);
        std::copy(halo.begin(), halo.end(), members.begin());
        std::iota(members.end() - own, members.end(), cell.begin);
        const int width = Padded(m + own);
        M.assign(static_cast<std::size_t>(m) * width, 0.0f);
        local.Fill(members, width, M.data());
        for (int a = 0; a < own; ++a) M[static_cast<std::size_t>(m - own + a) * width + m + a] = 1.0f;
        solved = kernels.inverse_rows(M.data(), m, own, width, rows.data()) &&
                 std::all_of(rows.begin(), rows.end(), [](float v) { return std::isfinite(v); });
      }
      if (solved) continue;
      const Real* const block = matrix.Block(leaf, leaf);
      members[0] = -1;  // the diagonal alone
      for (int a = 0; a < own; ++a) rows[a] = static_cast<float>(1.0 / block[static_cast<std::size_t>(a) * own + a]);
      ++plain;
    }
  });
  plain_leaves_ = plain;
}

void SchwarzInverse::Apply(std::span<const double> x, std::span<double> y) const {
  ParallelFor(static_cast<std::ptrdiff_t>(tree_.leaves.size()), threads_, 64, [&](std::ptrdiff_t leaf) {
    const Cell& cell = tree_.cells[tree_.leaves[leaf]];
    const std::span local(&members_[member_begin_[leaf]], member_begin_[leaf + 1] - member_begin_[leaf]);
    const float* const rows = &rows_[row_begin_[leaf]];
    if (local[0] < 0) {
      for (int i = 0; i < cell.count(); ++i) y[cell.begin + i] = rows[i] * x[cell.begin + i];
      return;
    }
    std::vector<float> gathered(local.size()), own(cell.count(), 0.0f);
    for (std::size_t j = 0; j < local.size(); ++j) gathered[j] = static_cast<float>(x[local[j]]);
    kernels_.single_precision.multiply(rows, cell.count(), static_cast<std::ptrdiff_t>(local.size()), gathered.data(),
                                       own.data());
    for (int i = 0; i < cell.count(); ++i) y[cell.begin + i] = own[i];
  });
}

template SchwarzInverse::SchwarzInverse(const Panels&, const Tree&, const SourceLists&, const NearField<float>&, int,
                                        int, const Kernels&);
template SchwarzInverse::SchwarzInverse(const Panels&, const Tree&, const SourceLists&, const NearField<double>&, int,
                                        int, const Kernels&);

}  // namespace geond::charge
