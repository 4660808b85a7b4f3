// SPDX-License-Identifier: Apache-2.0
#include "core/charge/near_field.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <utility>

#include "core/base/parallel.h"
#include "core/charge/quadrature.h"

namespace geond::charge {
namespace {

// All centroids, leaf by leaf, each leaf padded: as they are for the exact integral, and in Real, seen from the leaf's
// centre, for the quadratures.
template <typename Real>
struct LeafPoints {
  std::vector<std::size_t> begin;  // of each leaf
  std::vector<double> x, y, z;
  std::vector<Real> from_centre_x, from_centre_y, from_centre_z;

  LeafPoints(const Tree& tree, const Panels& panels) {
    std::size_t total = 0;
    for (int leaf : tree.leaves) {
      begin.push_back(total);
      total += Padded(tree.cells[leaf].count());
    }
    for (auto* values : {&x, &y, &z}) values->assign(total, 0.0);
    for (auto* values : {&from_centre_x, &from_centre_y, &from_centre_z}) values->assign(total, Real(0));
    for (std::size_t l = 0; l < tree.leaves.size(); ++l) {
      const Cell& leaf = tree.cells[tree.leaves[l]];
      for (int i = 0; i < leaf.count(); ++i) {
        const int t = tree.order[leaf.begin + i];
        const std::size_t at = begin[l] + i;
        x[at] = panels.x[t], y[at] = panels.y[t], z[at] = panels.z[t];
        from_centre_x[at] = static_cast<Real>(x[at] - leaf.centre.x());
        from_centre_y[at] = static_cast<Real>(y[at] - leaf.centre.y());
        from_centre_z[at] = static_cast<Real>(z[at] - leaf.centre.z());
      }
    }
  }
};

// A source triangle, ready for every leaf near it.
template <typename Real>
struct SourceTriangle {
  TriangleFrame frame;
  Eigen::Vector3d centroid;
  double diameter;
  TrianglePoints<Real, 7> seven, three;  // seen from the source leaf's centre
};

// Fills the columns of one source leaf's triangles in the rows of the leaves near it. Kept between leaves for its memory.
template <typename Real>
class ColumnFiller {
 public:
  ColumnFiller(const LeafPoints<Real>& points, const NearRule& rule, const Kernels& kernels)
      : points_(points), rule_(rule), kernels_(kernels) {}

  void SetSource(const TriangleMesh& mesh, const Panels& panels, const Tree& tree, const Cell& source) {
    centre_ = source.centre;
    sources_.clear();
    for (int i = source.begin; i < source.end; ++i) {
      const int t = tree.order[i];
      sources_.push_back({FrameOf(mesh, t), Eigen::Vector3d(panels.x[t], panels.y[t], panels.z[t]), panels.diameter[t],
                          TrianglePoints<Real, 7>(kSevenPoints, mesh, t, centre_, panels.area[t]),
                          TrianglePoints<Real, 7>(kThreePoints, mesh, t, centre_, panels.area[t])});
    }
  }

  void Fill(std::size_t leaf_place, const Cell& leaf, Real* values) {
    const int rows = leaf.count(), padded = Padded(rows);
    const std::size_t first = points_.begin[leaf_place];
    const Eigen::Vector3d apart = centre_ - leaf.centre;
    const Eigen::Matrix<Real, 3, 1> shift = apart.template cast<Real>();
    last_.resize(padded);
    Real* const end = values + sources_.size() * rows;
    for (const SourceTriangle<Real>& source : sources_) {
      // A padded column runs over into the next ones, which come after; but not into the block behind.
      const bool is_last = values + padded > end;
      const double nearest = (source.centroid - leaf.centre).norm() - leaf.centroid_radius;
      const bool some_exact = nearest < rule_.exact_within * source.diameter;
      const int exact = some_exact ? FindExact(first, rows, source) : 0;
      if (exact < rows) {
        const auto& rule = nearest < rule_.seven_points_within * source.diameter ? source.seven : source.three;
        Real x[7], y[7], z[7];
        for (int g = 0; g < rule.count; ++g) {
          x[g] = rule.x[g] + shift.x(), y[g] = rule.y[g] + shift.y(), z[g] = rule.z[g] + shift.z();
        }
        LoopsOf<Real>(kernels_).point_potential(padded, &points_.from_centre_x[first], &points_.from_centre_y[first],
                                                &points_.from_centre_z[first], rule.count, x, y, z, rule.weight,
                                                is_last ? last_.data() : values);
        if (is_last) std::memcpy(values, last_.data(), rows * sizeof(Real));
      }
      if (exact > 0) {
        integral_.resize(exact);
        kernels_.triangle_potential(source.frame, x_.data(), y_.data(), z_.data(), exact, integral_.data());
        for (int e = 0; e < exact; ++e) values[which_[e]] = static_cast<Real>(integral_[e]);
      }
      values += rows;
    }
  }

 private:
  // Lists the points too near for a quadrature, and counts them.
  int FindExact(std::size_t first, int rows, const SourceTriangle<Real>& source) {
    const double reach = rule_.exact_within * source.diameter;
    x_.resize(rows), y_.resize(rows), z_.resize(rows), which_.resize(rows);
    int count = 0;
    for (int i = 0; i < rows; ++i) {
      const double x = points_.x[first + i], y = points_.y[first + i], z = points_.z[first + i];
      const double dx = x - source.centroid.x(), dy = y - source.centroid.y(), dz = z - source.centroid.z();
      x_[count] = x, y_[count] = y, z_[count] = z, which_[count] = i;
      count += dx * dx + dy * dy + dz * dz < reach * reach;
    }
    return count;
  }

  const LeafPoints<Real>& points_;
  const NearRule& rule_;
  const Kernels& kernels_;
  Eigen::Vector3d centre_;
  std::vector<SourceTriangle<Real>> sources_;
  std::vector<Real> last_;
  std::vector<double> x_, y_, z_, integral_;
  std::vector<int> which_;
};

}  // namespace

template <typename Real>
NearField<Real>::NearField(const TriangleMesh& mesh, const Panels& panels, const Tree& tree,
                           const Interactions::Lists& near, const NearRule& rule, int threads, const Kernels& kernels)
    : tree_(tree), near_(near), kernels_(kernels), block_begin_(near.source.size()) {
  const std::size_t leaves = tree.leaves.size();
  for (std::size_t target = 0; target < leaves; ++target) {
    const auto rows = static_cast<std::size_t>(tree.cells[tree.leaves[target]].count());
    for (std::size_t pair = near.begin[target]; pair < near.begin[target + 1]; ++pair) {
      block_begin_[pair] = value_count_;
      value_count_ += rows * tree.cells[tree.leaves[near.source[pair]]].count();
    }
  }
  values_.reset(new Real[value_count_ + kPadding]);
  std::fill_n(values_.get() + value_count_, kPadding, Real(0));

  // A triangle's frame and points are made once, for all the leaves it is near to: so go by source.
  std::vector<std::size_t> begin(leaves + 1, 0);
  for (int source : near.source) ++begin[source + 1];
  for (std::size_t s = 0; s < leaves; ++s) begin[s + 1] += begin[s];
  std::vector<std::pair<int, std::size_t>> by_source(near.source.size());  // target leaf, pair
  std::vector<std::size_t> next(begin.begin(), begin.end() - 1);
  for (std::size_t target = 0; target < leaves; ++target) {
    for (std::size_t pair = near.begin[target]; pair < near.begin[target + 1]; ++pair) {
      by_source[next[near.source[pair]]++] = {static_cast<int>(target), pair};
    }
  }
  constexpr std::ptrdiff_t kSources = 16;  // source leaves to a task
  const LeafPoints<Real> points(tree, panels);
  ParallelFor((static_cast<std::ptrdiff_t>(leaves) + kSources - 1) / kSources, threads, 1, [&](std::ptrdiff_t task) {
    ColumnFiller<Real> filler(points, rule, kernels);
    const std::size_t end = std::min<std::size_t>(leaves, (task + 1) * kSources);
    for (std::size_t source = task * kSources; source < end; ++source) {
      filler.SetSource(mesh, panels, tree, tree.cells[tree.leaves[source]]);
      for (std::size_t i = begin[source]; i < begin[source + 1]; ++i) {
        const auto& [target, pair] = by_source[i];
        filler.Fill(target, tree.cells[tree.leaves[target]], &values_[block_begin_[pair]]);
      }
    }
  });
}

template <typename Real>
void NearField<Real>::AddPotential(int leaf, std::span<const Real> x, Real* potential) const {
  const int rows = tree_.cells[tree_.leaves[leaf]].count();
  const Kernels::Loops<Real>& loops = LoopsOf<Real>(kernels_);
  // Leaves that follow one another are one run of columns.
  for (std::size_t pair = near_.begin[leaf]; pair < near_.begin[leaf + 1];) {
    const Cell& first = tree_.cells[tree_.leaves[near_.source[pair]]];
    const std::size_t values = block_begin_[pair];
    int end = first.end;
    for (++pair; pair < near_.begin[leaf + 1]; ++pair) {
      const Cell& cell = tree_.cells[tree_.leaves[near_.source[pair]]];
      if (cell.begin != end) break;
      end = cell.end;
    }
    loops.multiply(&values_[values], rows, end - first.begin, &x[first.begin], potential);
  }
}

template <typename Real>
const Real* NearField<Real>::Block(int target, int source) const {
  const auto begin = near_.source.begin() + near_.begin[target], end = near_.source.begin() + near_.begin[target + 1];
  const auto found = std::lower_bound(begin, end, source);
  return found != end && *found == source ? &values_[block_begin_[found - near_.source.begin()]] : nullptr;
}

template class NearField<float>;
template class NearField<double>;

}  // namespace geond::charge
