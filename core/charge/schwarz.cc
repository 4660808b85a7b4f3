// SPDX-License-Identifier: Apache-2.0
#include "core/charge/schwarz.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <utility>

#include "core/base/parallel.h"

namespace geond::charge {
namespace {

// Members of the local problem that lie in one leaf.
struct Group {
  int leaf;
  int begin, end;  // among the members
};

// The `wanted` triangles of near leaves that lie nearest to the box around the leaf's own centroids, leaf by leaf.
std::vector<std::pair<int, int>> ChooseHalo(int leaf, const Panels& panels, const Tree& tree,
                                            const Interactions::Lists& near, int wanted) {
  const Cell& own = tree.cells[tree.leaves[leaf]];
  const auto place = [&](int i) {
    const int t = tree.order[i];
    return Eigen::Array3d(panels.x[t], panels.y[t], panels.z[t]);
  };
  Eigen::Array3d low = place(own.begin), high = low;
  for (int i = own.begin; i < own.end; ++i) low = low.min(place(i)), high = high.max(place(i));

  struct Candidate {
    double distance;
    int leaf, triangle;
    bool operator<(const Candidate& other) const {
      return std::pair(distance, triangle) < std::pair(other.distance, other.triangle);
    }
  };
  std::vector<Candidate> candidates;
  for (std::size_t pair = near.begin[leaf]; pair < near.begin[leaf + 1]; ++pair) {
    const int source = near.source[pair];
    if (source == leaf) continue;
    const Cell& cell = tree.cells[tree.leaves[source]];
    for (int i = cell.begin; i < cell.end; ++i) {
      const Eigen::Array3d p = place(i);
      candidates.push_back({(low - p).max(p - high).max(0.0).matrix().squaredNorm(), source, i});
    }
  }
  if (static_cast<int>(candidates.size()) > wanted) {
    std::nth_element(candidates.begin(), candidates.begin() + wanted, candidates.end());
    candidates.resize(std::max(wanted, 0));
  }
  std::vector<std::pair<int, int>> halo;
  for (const Candidate& candidate : candidates) halo.emplace_back(candidate.leaf, candidate.triangle);
  std::sort(halo.begin(), halo.end());
  return halo;
}

}  // namespace

template <typename Real>
SchwarzInverse::SchwarzInverse(const Panels& panels, const Tree& tree, const Interactions::Lists& near,
                               const NearField<Real>& matrix, int most, int threads, const Kernels& kernels)
    : tree_(tree), kernels_(kernels), threads_(threads) {
  const std::size_t leaves = tree.leaves.size();
  std::vector<std::vector<int>> members(leaves);
  std::vector<std::vector<float>> rows(leaves);
  std::atomic<int> plain{0};
  ParallelFor(static_cast<std::ptrdiff_t>(leaves), threads, 16, [&](std::ptrdiff_t l) {
    const int leaf = static_cast<int>(l);
    const Cell& cell = tree.cells[tree.leaves[leaf]];
    const int own = cell.count();
    // Own triangles last: the elimination then meets their right-hand sides late.
    std::vector<Group> groups;
    std::vector<int>& local = members[leaf];
    for (const auto& [source, triangle] : ChooseHalo(leaf, panels, tree, near, own <= most ? most - own : 0)) {
      if (groups.empty() || groups.back().leaf != source) {
        groups.push_back({source, static_cast<int>(local.size()), static_cast<int>(local.size())});
      }
      local.push_back(triangle);
      ++groups.back().end;
    }
    groups.push_back({leaf, static_cast<int>(local.size()), static_cast<int>(local.size()) + own});
    for (int i = cell.begin; i < cell.end; ++i) local.push_back(i);

    const int m = static_cast<int>(local.size()), width = Padded(m + own);
    std::vector<float> M(static_cast<std::size_t>(m) * width, 0.0f);
    for (const Group& target : groups) {
      const Cell& target_cell = tree.cells[tree.leaves[target.leaf]];
      for (const Group& source : groups) {
        const Cell& source_cell = tree.cells[tree.leaves[source.leaf]];
        const Real* const block = matrix.Block(target.leaf, source.leaf);
        for (int k = source.begin; k < source.end; ++k) {
          float* const column = &M[static_cast<std::size_t>(k) * width];  // of A, a row of its transpose
          if (block) {
            const auto at = static_cast<std::ptrdiff_t>(local[k] - source_cell.begin) * target_cell.count();
            const Real* const from = block + at - target_cell.begin;
            for (int i = target.begin; i < target.end; ++i) column[i] = static_cast<float>(from[local[i]]);
          } else {
            for (int i = target.begin; i < target.end; ++i) {
              const int a = tree.order[local[i]], b = tree.order[local[k]];
              column[i] = static_cast<float>(
                  panels.area[b] /
                  std::hypot(panels.x[a] - panels.x[b], panels.y[a] - panels.y[b], panels.z[a] - panels.z[b]));
            }
          }
        }
      }
    }
    for (int a = 0; a < own; ++a) M[static_cast<std::size_t>(m - own + a) * width + m + a] = 1.0f;
    rows[leaf].resize(static_cast<std::size_t>(m) * own);
    const bool solved = own <= most && kernels.inverse_rows(M.data(), m, own, width, rows[leaf].data()) &&
                        std::all_of(rows[leaf].begin(), rows[leaf].end(), [](float v) { return std::isfinite(v); });
    if (solved) return;
    const Real* const block = matrix.Block(leaf, leaf);
    local.assign(1, -1);  // the diagonal alone
    rows[leaf].resize(own);
    for (int a = 0; a < own; ++a) rows[leaf][a] = static_cast<float>(1.0 / block[static_cast<std::size_t>(a) * own + a]);
    ++plain;
  });
  plain_leaves_ = plain;
  member_begin_ = {0}, row_begin_ = {0};
  for (std::size_t leaf = 0; leaf < leaves; ++leaf) {
    member_begin_.push_back(member_begin_.back() + members[leaf].size());
    row_begin_.push_back(row_begin_.back() + rows[leaf].size());
  }
  members_.resize(member_begin_.back());
  rows_.resize(row_begin_.back() + kPadding);
  ParallelFor(static_cast<std::ptrdiff_t>(leaves), threads, 64, [&](std::ptrdiff_t leaf) {
    std::copy(members[leaf].begin(), members[leaf].end(), members_.begin() + member_begin_[leaf]);
    std::copy(rows[leaf].begin(), rows[leaf].end(), rows_.begin() + row_begin_[leaf]);
    members[leaf] = {};
    rows[leaf] = {};
  });
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

template SchwarzInverse::SchwarzInverse(const Panels&, const Tree&, const Interactions::Lists&, const NearField<float>&, int,
                                        int, const Kernels&);
template SchwarzInverse::SchwarzInverse(const Panels&, const Tree&, const Interactions::Lists&, const NearField<double>&, int,
                                        int, const Kernels&);

}  // namespace geond::charge
