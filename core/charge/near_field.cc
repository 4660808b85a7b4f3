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

// The points of one leaf in two forms: as they are, for the exact integral, and seen from the leaf's centre in Real for the
// quadratures, padded.
template <typename Real>
struct LeafPoints {
  std::vector<double> x, y, z;
  std::vector<Real> from_centre_x, from_centre_y, from_centre_z;

  LeafPoints(const Cell& leaf, const Tree& tree, const Panels& panels) {
    const int padded = Padded(leaf.count());
    from_centre_x.assign(padded, 0), from_centre_y.assign(padded, 0), from_centre_z.assign(padded, 0);
    for (int i = 0; i < leaf.count(); ++i) {
      const int t = tree.order[leaf.begin + i];
      x.push_back(panels.x[t]), y.push_back(panels.y[t]), z.push_back(panels.z[t]);
      from_centre_x[i] = static_cast<Real>(panels.x[t] - leaf.centre.x());
      from_centre_y[i] = static_cast<Real>(panels.y[t] - leaf.centre.y());
      from_centre_z[i] = static_cast<Real>(panels.z[t] - leaf.centre.z());
    }
  }
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
  ParallelFor(static_cast<std::ptrdiff_t>(leaves), threads, 8, [&](std::ptrdiff_t source) {
    const std::span all(by_source);
    FillColumns(static_cast<int>(source), mesh, panels, rule, all.subspan(begin[source], begin[source + 1] - begin[source]));
  });
}

template <typename Real>
void NearField<Real>::FillColumns(int source, const TriangleMesh& mesh, const Panels& panels, const NearRule& rule,
                                  std::span<const std::pair<int, std::size_t>> targets) {
  const Cell& cell = tree_.cells[tree_.leaves[source]];
  const Kernels::Loops<Real>& loops = LoopsOf<Real>(kernels_);
  std::vector<TriangleFrame> frames(cell.count());
  for (int k = 0; k < cell.count(); ++k) frames[k] = FrameOf(mesh, tree_.order[cell.begin + k]);

  std::vector<Real> column;
  std::vector<double> x, y, z, exact;  // of the points that need the exact integral
  std::vector<int> which;
  for (const auto& [target, pair] : targets) {
    const Cell& leaf = tree_.cells[tree_.leaves[target]];
    const LeafPoints<Real> points(leaf, tree_, panels);
    const int rows = leaf.count();
    column.resize(Padded(rows));
    for (int k = 0; k < cell.count(); ++k) {
      const int t = tree_.order[cell.begin + k];
      const Eigen::Vector3d centroid(panels.x[t], panels.y[t], panels.z[t]);
      const double diameter = panels.diameter[t], exact_reach = rule.exact_within * diameter;
      const double nearest = (centroid - leaf.centre).norm() - leaf.centroid_radius;
      Real* const values = &values_[block_begin_[pair] + static_cast<std::size_t>(k) * rows];
      which.clear();
      if (nearest < exact_reach) {
        x.clear(), y.clear(), z.clear();
        for (int i = 0; i < rows; ++i) {
          const double dx = points.x[i] - centroid.x(), dy = points.y[i] - centroid.y(), dz = points.z[i] - centroid.z();
          if (dx * dx + dy * dy + dz * dz >= exact_reach * exact_reach) continue;
          which.push_back(i);
          x.push_back(points.x[i]), y.push_back(points.y[i]), z.push_back(points.z[i]);
        }
        exact.resize(which.size());
        if (!which.empty()) {
          kernels_.triangle_potential(frames[k], x.data(), y.data(), z.data(), static_cast<int>(which.size()), exact.data());
        }
      }
      if (static_cast<int>(which.size()) < rows) {
        const bool seven = nearest < rule.seven_points_within * diameter;
        const auto quadrature = seven ? TrianglePoints<Real, 7>(kSevenPoints, mesh, t, leaf.centre, panels.area[t])
                                      : TrianglePoints<Real, 7>(kThreePoints, mesh, t, leaf.centre, panels.area[t]);
        loops.point_potential(static_cast<int>(column.size()), points.from_centre_x.data(), points.from_centre_y.data(),
                              points.from_centre_z.data(), quadrature.count, quadrature.x, quadrature.y, quadrature.z,
                              quadrature.weight, column.data());
        std::memcpy(values, column.data(), rows * sizeof(Real));
      }
      for (std::size_t e = 0; e < which.size(); ++e) values[which[e]] = static_cast<Real>(exact[e]);
    }
  }
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
