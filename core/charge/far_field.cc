// SPDX-License-Identifier: Apache-2.0
#include "core/charge/far_field.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdlib>
#include <map>
#include <unordered_map>
#include <utility>

#include "core/base/parallel.h"
#include "core/charge/harmonics.h"
#include "core/charge/quadrature.h"

namespace geond::charge {
namespace {

template <typename Real>
void CopyColumns(const Eigen::MatrixXd& matrix, int stride, Real* to) {
  for (Eigen::Index k = 0; k < matrix.cols(); ++k) {
    for (Eigen::Index row = 0; row < matrix.rows(); ++row) to[k * stride + row] = static_cast<Real>(matrix(row, k));
  }
}

template <typename Real>
std::vector<Real> ColumnsOf(const Eigen::MatrixXd& matrix, int stride) {
  std::vector<Real> columns(static_cast<std::size_t>(stride) * matrix.cols(), Real(0));
  CopyColumns(matrix, stride, columns.data());
  return columns;
}

// See OrderRule.
int OrderBetween(const Cell& target, const Cell& source, const OrderRule& rule) {
  const double distance = (target.centre - source.centre).norm(), a = target.centroid_radius,
               b = source.triangle_radius;
  const double ratio = std::max(b / (distance - a), a / (distance - b));
  // b over the size of a triangle in the target, and what of the bound is met: both as measured to serve best.
  const double triangles = b / a * std::sqrt(static_cast<double>(target.count()));
  const double wanted = rule.leap / std::sqrt(triangles), met = 0.7 * ratio;
  int order = 0;
  for (double error = met; order < rule.highest && error > wanted; error *= met) ++order;
  return std::max(order, rule.lowest);
}

int Octant(const Cell& child) {
  return (child.corner[0] & 1) | (child.corner[1] & 1) << 1 | (child.corner[2] & 1) << 2;
}

// What decides the matrix between two cells: by how many levels the source lies deeper, and the distance in half sides
// of the smaller, without signs. Packed in one number, to be sorted by.
struct Between {
  static constexpr int kBits = 19, kOffset = 32;
  std::uint64_t key = 0;
  int reflection = 0;

  Between(const Cell& target, const Cell& source) {
    const int deepest = std::max(target.level, source.level);
    key = static_cast<std::uint64_t>(source.level - target.level + kOffset);
    for (int axis = 0; axis < 3; ++axis) {
      const auto centre = [&](const Cell& cell) {
        return (2 * static_cast<std::int64_t>(cell.corner[axis]) + 1) << (deepest - cell.level);
      };
      const std::int64_t distance = centre(target) - centre(source);
      if (distance < 0) reflection |= 1 << axis;
      key = key << kBits | static_cast<std::uint64_t>(std::abs(distance));
    }
  }

  static int Levels(std::uint64_t key) { return static_cast<int>(key >> 3 * kBits) - kOffset; }
  static Eigen::Vector3d Distance(std::uint64_t key) {
    constexpr std::uint64_t kMask = (std::uint64_t{1} << kBits) - 1;
    return Eigen::Vector3d(static_cast<double>(key >> 2 * kBits & kMask), static_cast<double>(key >> kBits & kMask),
                           static_cast<double>(key & kMask));
  }
};

}  // namespace

template <typename Real>
FarField<Real>::FarField(const TriangleMesh& mesh, const Panels& panels, const Tree& tree, const SourceLists& far,
                         const OrderRule& order, std::span<const RulePoint> rule, int threads, const Kernels& kernels)
    : tree_(tree), kernels_(kernels), threads_(threads) {
  MakeBatches(far, order);
  MakeShifts();
  MakeLeaves(mesh, panels, rule);
}

template <typename Real>
void FarField<Real>::MakeLeaves(const TriangleMesh& mesh, const Panels& panels, std::span<const RulePoint> rule) {
  gather_begin_ = {0}, evaluate_begin_ = {0};
  for (int c : tree_.leaves) {
    const auto count = static_cast<std::size_t>(order_[c] < 0 ? 0 : CoefficientCount(order_[c]));
    gather_begin_.push_back(gather_begin_.back() + Padded(count) * tree_.cells[c].count());
    evaluate_begin_.push_back(evaluate_begin_.back() + count * tree_.cells[c].count());
  }
  gather_.resize(gather_begin_.back() + kPadding);
  evaluate_.resize(evaluate_begin_.back() + kPadding);
  constexpr std::ptrdiff_t kLeaves = 32;  // to a task
  ParallelFor((std::ssize(tree_.leaves) + kLeaves - 1) / kLeaves, threads_, 1, [&](std::ptrdiff_t task) {
    std::vector<Real> x, y, z, U, sum;
    const auto harmonics = [&](const Cell& cell, int order, const auto& place) {
      const int padded = Padded(cell.count());
      for (auto* values : {&x, &y, &z}) values->assign(padded, Real(0));
      for (int i = 0; i < cell.count(); ++i) {
        const Eigen::Vector3d p = (place(tree_.order[cell.begin + i]) - cell.centre) / cell.half_side;
        x[i] = static_cast<Real>(p.x()), y[i] = static_cast<Real>(p.y()), z[i] = static_cast<Real>(p.z());
      }
      U.resize(static_cast<std::size_t>(padded) * CoefficientCount(order));
      LoopsOf<Real>(kernels_).harmonics(order, padded, x.data(), y.data(), z.data(), U.data());
      return padded;
    };
    for (std::ptrdiff_t leaf = task * kLeaves; leaf < std::min(std::ssize(tree_.leaves), (task + 1) * kLeaves);
         ++leaf) {
      const Cell& cell = tree_.cells[tree_.leaves[leaf]];
      const int order = order_[tree_.leaves[leaf]];
      if (order < 0) continue;
      const int count = CoefficientCount(order), rows = Padded(count);
      sum.assign(static_cast<std::size_t>(Padded(cell.count())) * count, Real(0));
      for (const RulePoint& point : rule) {
        harmonics(cell, order, [&](int t) { return PlaceOf(point, mesh, t); });
        const Real share = static_cast<Real>(point.share);
        for (std::size_t k = 0; k < sum.size(); ++k) sum[k] += share * U[k];
      }
      for (int i = 0; i < cell.count(); ++i) {
        const Real area = static_cast<Real>(panels.area[tree_.order[cell.begin + i]]);
        Real* const column = &gather_[gather_begin_[leaf] + static_cast<std::size_t>(i) * rows];
        for (int j = 0; j < count; ++j) column[j] = area * sum[static_cast<std::size_t>(j) * Padded(cell.count()) + i];
      }
      const int padded =
          harmonics(cell, order, [&](int t) { return Eigen::Vector3d(panels.x[t], panels.y[t], panels.z[t]); });
      for (int j = 0; j < count; ++j) {
        std::copy_n(&U[static_cast<std::size_t>(j) * padded], cell.count(),
                    &evaluate_[evaluate_begin_[leaf] + static_cast<std::size_t>(j) * cell.count()]);
      }
    }
  });
}

template <typename Real>
void FarField<Real>::MakeShifts() {
  const int order = *std::max_element(order_.begin(), order_.end());
  if (order < 0) return;  // nobody is far
  stride_ = Padded(CoefficientCount(order));
  for (int octant = 0; octant < 8; ++octant) {
    const Eigen::Vector3d shift(octant & 1 ? 0.5 : -0.5, octant & 2 ? 0.5 : -0.5, octant & 4 ? 0.5 : -0.5);
    const Eigen::MatrixXd T = ShiftMatrix(shift, 0.5, order);
    up_[octant] = ColumnsOf<Real>(T, stride_);
    down_[octant] = ColumnsOf<Real>(T.transpose(), stride_);
    const std::vector<double> signs = ReflectionSigns(octant, order);
    signs_[octant].assign(stride_, Real(0));
    std::copy(signs.begin(), signs.end(), signs_[octant].begin());
  }
}

// A cell has the order of its pairs; and what its parent takes from it and gives it needs about half the parent's, here
// one less than that.
template <typename Real>
void FarField<Real>::PlaceVectors() {
  vector_begin_.assign(1, 0);
  for (std::size_t c = 0; c < tree_.cells.size(); ++c) {
    const int parent = tree_.cells[c].parent;
    if (parent >= 0) order_[c] = std::max(order_[c], order_[parent] - (order_[parent] > 0));
    vector_begin_.push_back(vector_begin_.back() +
                            (order_[c] < 0 ? 0 : Padded(CoefficientCount(order_[c])) / kPadding));
  }
  multipoles_.resize(static_cast<std::size_t>(vector_begin_.back()) * kPadding);
  locals_.resize(multipoles_.size());
}

template <typename Real>
void FarField<Real>::MakeBatches(const SourceLists& far, const OrderRule& rule) {
  const int cells = static_cast<int>(tree_.cells.size());
  const int group_size = std::clamp(cells / 8, 64, 4096);
  for (int first = 0; first < cells; first += group_size) group_cells_.push_back(first);
  group_cells_.push_back(cells);
  const auto groups = static_cast<std::ptrdiff_t>(group_cells_.size()) - 1;

  // What kind of pair each is, kinds counted group by group as they appear; the orders that pairs ask of kinds and
  // cells.
  struct Group {
    std::vector<std::uint64_t> kinds;
    std::vector<int> highest;               // order of each kind
    std::vector<std::array<int, 3>> pairs;  // place of the kind, order, reflection; in the order of the lists
  };
  std::vector<Group> found(groups);
  order_.assign(tree_.cells.size(), -1);
  ParallelFor(groups, threads_, 1, [&](std::ptrdiff_t g) {
    Group& group = found[g];
    std::unordered_map<std::uint64_t, int> place_of;
    group.pairs.reserve(far.begin[group_cells_[g + 1]] - far.begin[group_cells_[g]]);
    for (int target = group_cells_[g]; target < group_cells_[g + 1]; ++target) {
      for (std::size_t i = far.begin[target]; i < far.begin[target + 1]; ++i) {
        const Cell &to = tree_.cells[target], &from = tree_.cells[far.source[i]];
        const Between between(to, from);
        const int order = OrderBetween(to, from, rule);
        const auto [place, is_new] = place_of.try_emplace(between.key, static_cast<int>(group.kinds.size()));
        if (is_new) group.kinds.push_back(between.key), group.highest.push_back(order);
        group.highest[place->second] = std::max(group.highest[place->second], order);
        group.pairs.push_back({place->second, order, between.reflection});
        for (int cell : {target, far.source[i]}) {
          std::atomic_ref<int> highest(order_[cell]);
          for (int before = highest; before < order && !highest.compare_exchange_weak(before, order);) {
          }
        }
      }
    }
  });
  PlaceVectors();

  std::map<std::uint64_t, int> kinds;  // and the highest order of each
  for (const Group& group : found) {
    for (std::size_t k = 0; k < group.kinds.size(); ++k) {
      int& highest = kinds.try_emplace(group.kinds[k], 0).first->second;
      highest = std::max(highest, group.highest[k]);
    }
  }
  std::vector<std::pair<std::uint64_t, int>> sorted(kinds.begin(), kinds.end());
  std::size_t size = 0;
  for (const auto& [key, order] : sorted) {
    const int count = CoefficientCount(order);
    matrices_.push_back({size, Padded(count)});
    size += static_cast<std::size_t>(count) * Padded(count);
  }
  across_.resize(size);
  ParallelFor(std::ssize(sorted), threads_, 4, [&](std::ptrdiff_t k) {
    const auto& [key, order] = sorted[k];
    // The key counts in half sides of the smaller cell, the matrix in those of the target.
    const int levels = Between::Levels(key);
    const Eigen::Vector3d distance = std::ldexp(1.0, -std::max(0, levels)) * Between::Distance(key);
    CopyColumns(MultipoleToLocalMatrix(distance, std::ldexp(1.0, -levels), order, order + kDegreesBeyond),
                matrices_[k].stride, &across_[matrices_[k].begin]);
  });

  // The pairs of each group, those of one kind and order together.
  pairs_.resize(far.source.size());
  batches_.resize(groups);
  ParallelFor(groups, threads_, 1, [&](std::ptrdiff_t g) {
    const Group& group = found[g];
    const int orders = rule.highest + 1;
    std::vector<int> next(group.kinds.size() * orders + 1, 0);
    for (const auto& [kind, order, reflection] : group.pairs) ++next[kind * orders + order + 1];
    const std::size_t first = far.begin[group_cells_[g]];
    for (std::size_t kind = 0; kind < group.kinds.size(); ++kind) {
      const int matrix = static_cast<int>(
          std::lower_bound(sorted.begin(), sorted.end(), std::pair(group.kinds[kind], 0)) - sorted.begin());
      for (int order = 0; order < orders; ++order) {
        const std::size_t at = kind * orders + order;
        if (next[at + 1] > 0) batches_[g].push_back({matrix, order, first + next[at], first + next[at] + next[at + 1]});
        next[at + 1] += next[at];
      }
    }
    std::size_t pair = 0;
    for (int target = group_cells_[g]; target < group_cells_[g + 1]; ++target) {
      for (std::size_t i = far.begin[target]; i < far.begin[target + 1]; ++i) {
        const auto& [kind, order, reflection] = group.pairs[pair++];
        pairs_[first + next[kind * orders + order]++] = {vector_begin_[target], vector_begin_[far.source[i]],
                                                         reflection};
      }
    }
  });
}

template <typename Real>
void FarField<Real>::Spread(std::span<const Real> x) {
  Gather(x);
  Across();
  Scatter();
}

template <typename Real>
void FarField<Real>::Gather(std::span<const Real> x) {
  const Kernels::Loops<Real>& loops = LoopsOf<Real>(kernels_);
  std::fill(multipoles_.begin(), multipoles_.end(), Real(0));
  ParallelFor(static_cast<std::ptrdiff_t>(tree_.leaves.size()), threads_, 64, [&](std::ptrdiff_t leaf) {
    const int c = tree_.leaves[leaf];
    if (order_[c] < 0) return;
    const Cell& cell = tree_.cells[c];
    loops.multiply(&gather_[gather_begin_[leaf]], Padded(CoefficientCount(order_[c])), cell.count(), &x[cell.begin],
                   VectorOf(multipoles_, c));
  });
  for (int level = static_cast<int>(tree_.level_begin.size()) - 2; level >= 0; --level) {
    const int first = tree_.level_begin[level], count = tree_.level_begin[level + 1] - first;
    ParallelFor(count, count < 64 ? 1 : threads_, 32, [&](std::ptrdiff_t c) {
      const int to = static_cast<int>(first + c);
      const Cell& cell = tree_.cells[to];
      if (order_[to] < 0) return;
      for (int child = cell.first_child; child < cell.first_child + cell.child_count; ++child) {
        loops.translate(up_[Octant(tree_.cells[child])].data(), CoefficientCount(std::min(order_[child], order_[to])),
                        Padded(CoefficientCount(order_[to])), stride_, VectorOf(multipoles_, child),
                        VectorOf(multipoles_, to));
      }
    });
  }
}

template <typename Real>
void FarField<Real>::Across() {
  const Kernels::Loops<Real>& loops = LoopsOf<Real>(kernels_);
  std::array<const Real*, 8> signs;
  for (int reflection = 0; reflection < 8; ++reflection) signs[reflection] = signs_[reflection].data();
  ParallelFor(static_cast<std::ptrdiff_t>(group_cells_.size()) - 1, threads_, 1, [&](std::ptrdiff_t group) {
    std::fill(VectorOf(locals_, group_cells_[group]), VectorOf(locals_, group_cells_[group + 1]), Real(0));
    for (const Batch& batch : batches_[group]) {
      const Matrix& matrix = matrices_[batch.matrix];
      loops.translate_pairs(&across_[matrix.begin], batch.order, matrix.stride, &pairs_[batch.begin],
                            static_cast<int>(batch.end - batch.begin), signs.data(), multipoles_.data(),
                            locals_.data());
    }
    for (int c = group_cells_[group]; c < group_cells_[group + 1]; ++c) {
      const Real per_metre = static_cast<Real>(1.0 / tree_.cells[c].half_side);
      std::for_each(VectorOf(locals_, c), VectorOf(locals_, c + 1), [&](Real& value) { value *= per_metre; });
    }
  });
}

template <typename Real>
void FarField<Real>::Scatter() {
  const Kernels::Loops<Real>& loops = LoopsOf<Real>(kernels_);
  for (std::size_t level = 1; level + 1 < tree_.level_begin.size(); ++level) {
    const int first = tree_.level_begin[level], count = tree_.level_begin[level + 1] - first;
    ParallelFor(count, count < 64 ? 1 : threads_, 32, [&](std::ptrdiff_t c) {
      const int to = static_cast<int>(first + c);
      const Cell& cell = tree_.cells[to];
      if (order_[to] < 0 || order_[cell.parent] < 0) return;
      loops.translate(down_[Octant(cell)].data(), CoefficientCount(order_[cell.parent]),
                      Padded(CoefficientCount(order_[to])), stride_, VectorOf(locals_, cell.parent),
                      VectorOf(locals_, to));
    });
  }
}

template <typename Real>
void FarField<Real>::AddPotential(int leaf, Real* potential) const {
  const int cell = tree_.leaves[leaf];
  if (order_[cell] < 0) return;
  LoopsOf<Real>(kernels_).multiply(&evaluate_[evaluate_begin_[leaf]], tree_.cells[cell].count(),
                                   CoefficientCount(order_[cell]),
                                   &locals_[static_cast<std::size_t>(vector_begin_[cell]) * kPadding], potential);
}

template <typename Real>
std::ptrdiff_t FarField<Real>::multiplications() const {
  std::ptrdiff_t sum = 0;
  for (const auto& group : batches_) {
    for (const Batch& batch : group) {
      std::ptrdiff_t entries = 0;
      for (int n = 0; n <= batch.order; ++n) {
        entries += (2 * n + 1) * CoefficientCount(std::min(batch.order, batch.order + kDegreesBeyond - n));
      }
      sum += static_cast<std::ptrdiff_t>(batch.end - batch.begin) * entries;
    }
  }
  return sum;
}

template <typename Real>
std::size_t FarField<Real>::bytes() const {
  const std::size_t reals =
      gather_.size() + evaluate_.size() + 16 * up_[0].size() + across_.size() + multipoles_.size() + locals_.size();
  return reals * sizeof(Real) + pairs_.size() * sizeof(CellPair);
}

template class FarField<float>;
template class FarField<double>;

}  // namespace geond::charge
