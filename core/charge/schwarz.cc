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

// All centroids in the tree's order, seen from the first cell's centre; the leaf each lies in, and each leaf's box of
// them.
struct Places {
  struct Box {
    float low[3], high[3];
  };
  std::vector<float> x, y, z;
  std::vector<int> leaf;
  std::vector<Box> box;

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
      Box& of = box.emplace_back();
      for (int axis = 0; axis < 3; ++axis) {
        const std::vector<float>& values = axis == 0 ? x : axis == 1 ? y : z;
        const auto [low, high] = std::minmax_element(&values[cell.begin], &values[cell.begin] + cell.count());
        of.low[axis] = *low, of.high[axis] = *high;
      }
    }
  }
};

float SquaredDistance(const Places::Box& a, const Places::Box& b) {
  float sum = 0.0f;
  for (int axis = 0; axis < 3; ++axis) {
    const float apart = std::max({a.low[axis] - b.high[axis], b.low[axis] - a.high[axis], 0.0f});
    sum += apart * apart;
  }
  return sum;
}

// The `wanted` triangles of near leaves that lie nearest to the box around the leaf's own centroids, in order.
class HaloChoice {
 public:
  HaloChoice(const Places& places, const Tree& tree, const SourceLists& near)
      : places_(places), tree_(tree), near_(near) {}

  void Choose(int leaf, int wanted, std::vector<int>& halo) {
    halo.clear();
    if (wanted <= 0) return;
    // Leaves in the order of their boxes' distance; those beyond what has been found need not be looked into.
    const Places::Box& own = places_.box[leaf];
    leaves_.clear(), candidates_.clear();
    for (std::size_t pair = near_.begin[leaf]; pair < near_.begin[leaf + 1]; ++pair) {
      const int other = near_.source[pair];
      if (other != leaf) leaves_.push_back(Key(SquaredDistance(own, places_.box[other]), other));
    }
    std::sort(leaves_.begin(), leaves_.end());
    std::uint64_t farthest = ~std::uint64_t{0};  // that can still belong to the halo
    for (std::uint64_t key : leaves_) {
      if (key >> 32 > farthest >> 32) break;
      const Cell& cell = tree_.cells[tree_.leaves[key & 0xffffffffu]];
      for (int i = cell.begin; i < cell.end; ++i) {
        const float dx = std::max({own.low[0] - places_.x[i], places_.x[i] - own.high[0], 0.0f});
        const float dy = std::max({own.low[1] - places_.y[i], places_.y[i] - own.high[1], 0.0f});
        const float dz = std::max({own.low[2] - places_.z[i], places_.z[i] - own.high[2], 0.0f});
        const std::uint64_t candidate = Key(dx * dx + dy * dy + dz * dz, i);
        if (candidate < farthest) candidates_.push_back(candidate);
      }
      if (static_cast<int>(candidates_.size()) <= wanted) continue;
      std::nth_element(candidates_.begin(), candidates_.begin() + wanted, candidates_.end());
      farthest = candidates_[wanted];
      candidates_.resize(wanted);
    }
    for (std::uint64_t candidate : candidates_) halo.push_back(static_cast<int>(candidate & 0xffffffffu));
    std::sort(halo.begin(), halo.end());
  }

 private:
  // The bits of numbers that are not negative are in the order of the numbers; the place decides between equals.
  static std::uint64_t Key(float squared_distance, int place) {
    return std::uint64_t{std::bit_cast<std::uint32_t>(squared_distance)} << 32 | static_cast<std::uint32_t>(place);
  }

  const Places& places_;
  const Tree& tree_;
  const SourceLists& near_;
  std::vector<std::uint64_t> leaves_, candidates_;
};

// Row k of M, `width` apart, gets the column of member k: from the near field, and as if the charge sat at the centroid
// between members of leaves that are not near each other. Members are in the tree's order but for the leaf's own, the
// last.
template <typename Real>
class LocalMatrix {
 public:
  LocalMatrix(const Panels& panels, const Tree& tree, const Places& places, const NearField<Real>& matrix)
      : panels_(panels), tree_(tree), places_(places), matrix_(matrix) {}

  void Fill(std::span<const int> members, int width, float* M) {
    runs_.clear();
    for (int i = 0; i < std::ssize(members); ++i) {
      const int leaf = places_.leaf[members[i]];
      if (runs_.empty() || runs_.back().leaf != leaf) runs_.push_back({leaf, i, i});
      runs_.back().end = i + 1;
    }
    for (const Run& source : runs_) {
      for (const Run& target : runs_) {
        const Cell &from = tree_.cells[tree_.leaves[source.leaf]], &to = tree_.cells[tree_.leaves[target.leaf]];
        const Real* const block = matrix_.Block(target.leaf, source.leaf);
        for (int k = source.begin; k < source.end; ++k) {
          float* const column = M + static_cast<std::ptrdiff_t>(k) * width;
          if (block) {
            const Real* const values = block + static_cast<std::ptrdiff_t>(members[k] - from.begin) * to.count();
            for (int i = target.begin; i < target.end; ++i)
              column[i] = static_cast<float>(values[members[i] - to.begin]);
          } else {
            for (int i = target.begin; i < target.end; ++i) column[i] = FromAfar(members[k], members[i]);
          }
        }
      }
    }
  }

 private:
  struct Run {  // members of one leaf
    int leaf, begin, end;
  };
  float FromAfar(int source, int target) const {
    const float dx = places_.x[target] - places_.x[source], dy = places_.y[target] - places_.y[source],
                dz = places_.z[target] - places_.z[source];
    return static_cast<float>(panels_.area[tree_.order[source]]) / std::sqrt(dx * dx + dy * dy + dz * dz);
  }

  const Panels& panels_;
  const Tree& tree_;
  const Places& places_;
  const NearField<Real>& matrix_;
  std::vector<Run> runs_;
};

constexpr int kMostOwn = 256;  // triangles of a leaf that is solved: more lie at one place

}  // namespace

template <typename Real>
SchwarzInverse::SchwarzInverse(const Panels& panels, const Tree& tree, const SourceLists& near,
                               const NearField<Real>& matrix, int halo, int threads, const Kernels& kernels)
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
    const int members = own > kMostOwn ? 1 : std::min(own + halo, around);
    member_begin_.push_back(member_begin_.back() + members);
    row_begin_.push_back(row_begin_.back() + static_cast<std::size_t>(members) * own);
  }
  members_.resize(member_begin_.back());
  rows_ = MakeLargeArray<float>(row_begin_.back() + kPadding);
  std::fill_n(&rows_[row_begin_.back()], kPadding, 0.0f);
  std::atomic<int> plain{0};
  constexpr std::ptrdiff_t kLeaves = 16;  // to a task
  ParallelFor((static_cast<std::ptrdiff_t>(leaves) + kLeaves - 1) / kLeaves, threads, 1, [&](std::ptrdiff_t task) {
    LocalMatrix<Real> local(panels, tree, places, matrix);
    HaloChoice choice(places, tree, near);
    std::vector<int> around;
    std::vector<float> M;
    const int last = static_cast<int>(std::min<std::ptrdiff_t>(leaves, (task + 1) * kLeaves));
    for (int leaf = static_cast<int>(task * kLeaves); leaf < last; ++leaf) {
      const Cell& cell = tree.cells[tree.leaves[leaf]];
      const int own = cell.count(), m = static_cast<int>(member_begin_[leaf + 1] - member_begin_[leaf]);
      const std::span members(&members_[member_begin_[leaf]], static_cast<std::size_t>(m));
      const std::span rows(&rows_[row_begin_[leaf]], static_cast<std::size_t>(m) * own);
      bool solved = own <= kMostOwn;
      if (solved) {
        // Own triangles last: the elimination then meets their right-hand sides late.
        choice.Choose(leaf, m - own, around);
        std::copy(around.begin(), around.end(), members.begin());
        std::iota(members.end() - own, members.end(), cell.begin);
        const int width = Padded(m + own);
        M.resize(static_cast<std::size_t>(m) * width);
        for (int k = 0; k < m; ++k) std::fill_n(&M[static_cast<std::size_t>(k) * width + m], width - m, 0.0f);
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
