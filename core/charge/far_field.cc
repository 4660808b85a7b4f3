// SPDX-License-Identifier: Apache-2.0
#include "core/charge/far_field.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <utility>

#include "core/base/parallel.h"
#include "core/charge/harmonics.h"
#include "core/charge/quadrature.h"

namespace geond::charge {
namespace {

template <typename Real>
std::vector<Real> ColumnsOf(const Eigen::MatrixXd& matrix, int stride) {
  std::vector<Real> columns(static_cast<std::size_t>(stride) * matrix.cols(), Real(0));
  for (Eigen::Index k = 0; k < matrix.cols(); ++k) {
    for (Eigen::Index row = 0; row < matrix.rows(); ++row) columns[k * stride + row] = static_cast<Real>(matrix(row, k));
  }
  return columns;
}

int Octant(const Cell& child) {
  return (child.corner[0] & 1) | (child.corner[1] & 1) << 1 | (child.corner[2] & 1) << 2;
}

// What decides the matrix between two cells: the distance in half sides of the smaller, without signs, and by how many
// levels the source lies deeper. Packed in one number, to be sorted by.
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
                         int order, std::span<const RulePoint> rule, int threads, const Kernels& kernels)
    : tree_(tree), kernels_(kernels), rule_(rule), order_(order), count_(CoefficientCount(order)), stride_(Padded(count_)),
      threads_(threads) {
  PlacePoints(mesh, panels);
  MakeShifts();
  MakeBatches(far);
  multipoles_.resize(tree.cells.size() * stride_);
  locals_.resize(tree.cells.size() * stride_);
}

template <typename Real>
void FarField<Real>::PlacePoints(const TriangleMesh& mesh, const Panels& panels) {
  leaf_points_.assign(tree_.leaves.size() + 1, 0);
  for (std::size_t leaf = 0; leaf < tree_.leaves.size(); ++leaf) {
    leaf_points_[leaf + 1] = leaf_points_[leaf] + Padded(tree_.cells[tree_.leaves[leaf]].count());
  }
  const std::size_t total = leaf_points_.back();
  for (auto* points : {&point_x_, &point_y_, &point_z_}) points->resize(rule_.size() * total);
  for (auto* values : {&centroid_x_, &centroid_y_, &centroid_z_, &area_}) values->resize(total);
  ParallelFor(static_cast<std::ptrdiff_t>(tree_.leaves.size()), threads_, 64, [&](std::ptrdiff_t leaf) {
    const Cell& cell = tree_.cells[tree_.leaves[leaf]];
    const std::size_t first = leaf_points_[leaf], padded = leaf_points_[leaf + 1] - first;
    const double scale = 1.0 / cell.half_side;
    for (int i = 0; i < cell.count(); ++i) {
      const int t = tree_.order[cell.begin + i];
      const Eigen::Vector3d centroid = (Eigen::Vector3d(panels.x[t], panels.y[t], panels.z[t]) - cell.centre) * scale;
      centroid_x_[first + i] = static_cast<Real>(centroid.x());
      centroid_y_[first + i] = static_cast<Real>(centroid.y());
      centroid_z_[first + i] = static_cast<Real>(centroid.z());
      area_[first + i] = static_cast<Real>(panels.area[t]);
      for (std::size_t g = 0; g < rule_.size(); ++g) {
        const Eigen::Vector3d place = (PlaceOf(rule_[g], mesh, t) - cell.centre) * scale;
        const std::size_t at = rule_.size() * first + g * padded + i;
        point_x_[at] = static_cast<Real>(place.x());
        point_y_[at] = static_cast<Real>(place.y());
        point_z_[at] = static_cast<Real>(place.z());
      }
    }
  });
}

template <typename Real>
void FarField<Real>::MakeShifts() {
  for (int octant = 0; octant < 8; ++octant) {
    const Eigen::Vector3d shift(octant & 1 ? 0.5 : -0.5, octant & 2 ? 0.5 : -0.5, octant & 4 ? 0.5 : -0.5);
    const Eigen::MatrixXd T = ShiftMatrix(shift, 0.5, order_);
    up_[octant] = ColumnsOf<Real>(T, stride_);
    down_[octant] = ColumnsOf<Real>(T.transpose(), stride_);
    const std::vector<double> signs = ReflectionSigns(octant, order_);
    signs_[octant].assign(stride_, Real(0));
    std::copy(signs.begin(), signs.end(), signs_[octant].begin());
  }
}

template <typename Real>
void FarField<Real>::MakeBatches(const SourceLists& far) {
  const int cells = static_cast<int>(tree_.cells.size());
  const int group_size = std::clamp(cells / 8, 64, 4096);
  for (int first = 0; first < cells; first += group_size) group_cells_.push_back(first);
  group_cells_.push_back(cells);
  const auto groups = static_cast<std::ptrdiff_t>(group_cells_.size()) - 1;

  // Pairs of a group by kind, and all the kinds there are.
  using KeyedPair = std::pair<std::uint64_t, CellPair>;
  std::vector<std::vector<KeyedPair>> keyed(groups);
  std::vector<std::vector<std::uint64_t>> kinds_of(groups);
  ParallelFor(groups, threads_, 1, [&](std::ptrdiff_t g) {
    for (int target = group_cells_[g]; target < group_cells_[g + 1]; ++target) {
      for (std::size_t i = far.begin[target]; i < far.begin[target + 1]; ++i) {
        const Between between(tree_.cells[target], tree_.cells[far.source[i]]);
        keyed[g].push_back({between.key, {target, far.source[i], between.reflection}});
      }
    }
    std::stable_sort(keyed[g].begin(), keyed[g].end(), [](const KeyedPair& a, const KeyedPair& b) { return a.first < b.first; });
    for (const auto& [key, pair] : keyed[g]) {
      if (kinds_of[g].empty() || kinds_of[g].back() != key) kinds_of[g].push_back(key);
    }
  });
  std::vector<std::uint64_t> kinds;
  for (const auto& some : kinds_of) kinds.insert(kinds.end(), some.begin(), some.end());
  std::sort(kinds.begin(), kinds.end());
  kinds.erase(std::unique(kinds.begin(), kinds.end()), kinds.end());

  pairs_.reserve(far.source.size());
  group_begin_ = {0};
  for (auto& group : keyed) {
    std::uint64_t last = ~std::uint64_t{0};
    for (const auto& [key, pair] : group) {
      const int place = static_cast<int>(pairs_.size());
      if (key != last) {
        const auto found = std::lower_bound(kinds.begin(), kinds.end(), key);
        batches_.push_back({static_cast<int>(found - kinds.begin()), place, place});
      }
      last = key;
      pairs_.push_back(pair);
      batches_.back().end = place + 1;
    }
    group_begin_.push_back(static_cast<int>(batches_.size()));
    group = {};
  }

  across_.resize(kinds.size() * matrix_size());
  ParallelFor(static_cast<std::ptrdiff_t>(kinds.size()), threads_, 4, [&](std::ptrdiff_t k) {
    const int levels = Between::Levels(kinds[k]);
    // The key counts in half sides of the smaller cell, the matrix in those of the target.
    const Eigen::Vector3d distance = std::ldexp(1.0, -std::max(0, levels)) * Between::Distance(kinds[k]);
    const std::vector<Real> columns =
        ColumnsOf<Real>(MultipoleToLocalMatrix(distance, std::ldexp(1.0, -levels), order_), stride_);
    std::copy(columns.begin(), columns.end(), across_.begin() + k * matrix_size());
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
    const Cell& cell = tree_.cells[tree_.leaves[leaf]];
    const std::size_t first = leaf_points_[leaf], padded = leaf_points_[leaf + 1] - first;
    std::vector<Real> charges(rule_.size() * padded, Real(0));
    for (std::size_t g = 0; g < rule_.size(); ++g) {
      const Real share = static_cast<Real>(rule_[g].share);
      for (int i = 0; i < cell.count(); ++i) charges[g * padded + i] = share * x[cell.begin + i] * area_[first + i];
    }
    loops.add_multipole(order_, static_cast<int>(charges.size()), &point_x_[rule_.size() * first], &point_y_[rule_.size() * first],
                        &point_z_[rule_.size() * first], charges.data(), &multipoles_[static_cast<std::size_t>(tree_.leaves[leaf]) * stride_]);
  });
  for (int level = static_cast<int>(tree_.level_begin.size()) - 2; level >= 0; --level) {
    const int first = tree_.level_begin[level], count = tree_.level_begin[level + 1] - first;
    ParallelFor(count, count < 64 ? 1 : threads_, 32, [&](std::ptrdiff_t c) {
      const Cell& cell = tree_.cells[first + c];
      Real* const M = &multipoles_[static_cast<std::size_t>(first + c) * stride_];
      for (int child = cell.first_child; child < cell.first_child + cell.child_count; ++child) {
        loops.translate(up_[Octant(tree_.cells[child])].data(), count_, stride_,
                        &multipoles_[static_cast<std::size_t>(child) * stride_], M);
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
    const std::size_t first_cell = group_cells_[group], last_cell = group_cells_[group + 1];
    std::fill(locals_.begin() + first_cell * stride_, locals_.begin() + last_cell * stride_, Real(0));
    for (int b = group_begin_[group]; b < group_begin_[group + 1]; ++b) {
      const Batch& batch = batches_[b];
      loops.translate_pairs(&across_[batch.matrix * matrix_size()], count_, stride_, &pairs_[batch.begin],
                            batch.end - batch.begin, signs.data(), multipoles_.data(), locals_.data());
    }
    for (std::size_t c = first_cell; c < last_cell; ++c) {
      const Real per_metre = static_cast<Real>(1.0 / tree_.cells[c].half_side);
      for (int j = 0; j < stride_; ++j) locals_[c * stride_ + j] *= per_metre;
    }
  });
}

template <typename Real>
void FarField<Real>::Scatter() {
  const Kernels::Loops<Real>& loops = LoopsOf<Real>(kernels_);
  for (std::size_t level = 1; level + 1 < tree_.level_begin.size(); ++level) {
    const int first = tree_.level_begin[level], count = tree_.level_begin[level + 1] - first;
    ParallelFor(count, count < 64 ? 1 : threads_, 32, [&](std::ptrdiff_t c) {
      const Cell& cell = tree_.cells[first + c];
      loops.translate(down_[Octant(cell)].data(), count_, stride_,
                      &locals_[static_cast<std::size_t>(cell.parent) * stride_],
                      &locals_[static_cast<std::size_t>(first + c) * stride_]);
    });
  }
}

template <typename Real>
void FarField<Real>::AddPotential(int leaf, Real* potential) const {
  const std::size_t first = leaf_points_[leaf], padded = leaf_points_[leaf + 1] - first;
  LoopsOf<Real>(kernels_).add_potential(order_, static_cast<int>(padded), &centroid_x_[first], &centroid_y_[first],
                                        &centroid_z_[first],
                                        &locals_[static_cast<std::size_t>(tree_.leaves[leaf]) * stride_], potential);
}

template <typename Real>
std::size_t FarField<Real>::bytes() const {
  const std::size_t reals = 3 * point_x_.size() + 4 * centroid_x_.size() + 16 * up_[0].size() + across_.size() +
                            multipoles_.size() + locals_.size();
  return reals * sizeof(Real) + pairs_.size() * sizeof(CellPair) + batches_.size() * sizeof(Batch);
}

template class FarField<float>;
template class FarField<double>;

}  // namespace geond::charge
