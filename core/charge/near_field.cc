// SPDX-License-Identifier: Apache-2.0
#include "core/charge/near_field.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstring>
#include <utility>

#include "core/base/parallel.h"
#include "core/charge/quadrature.h"

namespace geond::charge {
namespace {

// All centroids, leaf by leaf, each leaf padded and seen from its centre; and as they are, in the tree's order: from
// another centroid near by they must be seen as exactly as they lie.
template <typename Real>
struct LeafPoints {
  std::vector<std::size_t> begin;  // of each leaf
  std::vector<Real> x, y, z;
  std::vector<Eigen::Vector3d> place;

  LeafPoints(const Tree& tree, const Panels& panels) {
    std::size_t total = 0;
    for (int leaf : tree.leaves) {
      begin.push_back(total);
      total += Padded(tree.cells[leaf].count());
    }
    for (auto* values : {&x, &y, &z}) values->assign(total, Real(0));
    place.resize(panels.size());
    for (std::size_t l = 0; l < tree.leaves.size(); ++l) {
      const Cell& leaf = tree.cells[tree.leaves[l]];
      for (int i = 0; i < leaf.count(); ++i) {
        const int t = tree.order[leaf.begin + i];
        const std::size_t at = begin[l] + i;
        place[leaf.begin + i] = {panels.x[t], panels.y[t], panels.z[t]};
        const Eigen::Vector3d from_centre = place[leaf.begin + i] - leaf.centre;
        x[at] = static_cast<Real>(from_centre.x());
        y[at] = static_cast<Real>(from_centre.y());
        z[at] = static_cast<Real>(from_centre.z());
      }
    }
  }
};

// The triangles of one source leaf, and the columns that they fill in the rows of the leaves near it. Kept between
// leaves for its memory.
template <typename Real>
class ColumnFiller {
 public:
  ColumnFiller(const TriangleMesh& mesh, const Panels& panels, const Tree& tree, const LeafPoints<Real>& points,
               const NearRule& rule, const Kernels& kernels)
      : mesh_(mesh), panels_(panels), tree_(tree), points_(points), rule_(rule), kernels_(kernels) {}

  void SetSource(const Cell& source) {
    source_ = &source;
    frames_.clear(), reach_.clear(), centroid_.clear();
    for (Points& points : rules_) points.x.clear(), points.y.clear(), points.z.clear(), points.weight.clear();
    largest_ = 0.0;
    for (int i = source.begin; i < source.end; ++i) {
      const int t = tree_.order[i];
      centroid_.emplace_back(panels_.x[t], panels_.y[t], panels_.z[t]);
      frames_.push_back(LocalFrameOf<Real>(mesh_, t, centroid_.back()));
      reach_.push_back(rule_.exact_within * panels_.diameter[t]);
      largest_ = std::max(largest_, panels_.diameter[t]);
      rules_[0].Add(kOnePoint, mesh_, t, source.centre, panels_.area[t]);
      rules_[1].Add(kThreePoints, mesh_, t, source.centre, panels_.area[t]);
      if (rule_.seven_points_within > 0.0) rules_[2].Add(kSevenPoints, mesh_, t, source.centre, panels_.area[t]);
    }
  }

  // All columns by quadrature.
  void Fill(std::size_t leaf_place, const Cell& leaf, Real* values) const {
    const std::size_t first = points_.begin[leaf_place];
    const Eigen::Vector3d apart = source_->centre - leaf.centre;
    const double nearest = (apart.norm() - leaf.centroid_radius - source_->centroid_radius) / largest_;
    const bool seven = rule_.seven_points_within > 0.0 && nearest < rule_.seven_points_within;
    const int which = seven ? 2 : nearest < rule_.three_points_within ? 1 : 0;
    const Real shift[3] = {static_cast<Real>(apart.x()), static_cast<Real>(apart.y()), static_cast<Real>(apart.z())};
    const Points& rule = rules_[which];
    LoopsOf<Real>(kernels_).point_columns(leaf.count(), &points_.x[first], &points_.y[first], &points_.z[first], shift,
                                          source_->count(), kPointCounts[which], rule.x.data(), rule.y.data(),
                                          rule.z.data(), rule.weight.data(), values);
  }

  // A leaf near the source, and its columns.
  struct Target {
    std::size_t leaf_place;
    const Cell* leaf;
    Real* values;
  };
  // What lies too near for quadrature, exactly: for each source triangle its points in all the leaves together. Returns
  // how many there are.
  std::size_t FillExact(std::span<const Target> targets) {
    const Kernels::Loops<Real>& loops = LoopsOf<Real>(kernels_);
    std::size_t room = 0, total = 0;
    const double largest_reach = *std::max_element(reach_.begin(), reach_.end()) + source_->centroid_radius;
    close_.clear();
    for (const Target& target : targets) {
      if ((source_->centre - target.leaf->centre).norm() > largest_reach + target.leaf->centroid_radius) continue;
      close_.push_back(target);
      room += Padded(target.leaf->count());
    }
    for (auto* values : {&x_, &y_, &z_, &integral_}) values->resize(room);
    to_.resize(room), who_.resize(room), which_.resize(room);
    for (int s = 0; s < source_->count(); ++s) {
      int found = 0;
      for (const Target& target : close_) {
        const Cell& leaf = *target.leaf;
        const Eigen::Vector3d apart = centroid_[s] - leaf.centre;
        const double farthest = reach_[s] + leaf.centroid_radius;
        if (apart.squaredNorm() > farthest * farthest) continue;
        const std::size_t first = points_.begin[target.leaf_place];
        const Real centre[3] = {static_cast<Real>(apart.x()), static_cast<Real>(apart.y()),
                                static_cast<Real>(apart.z())};
        const int count = loops.within_reach(leaf.count(), &points_.x[first], &points_.y[first], &points_.z[first],
                                             centre, static_cast<Real>(reach_[s] * reach_[s]), which_.data());
        Real* const column = target.values + static_cast<std::ptrdiff_t>(s) * leaf.count();
        for (int k = 0; k < count; ++k, ++found) {
          const Eigen::Vector3d seen = points_.place[leaf.begin + which_[k]] - centroid_[s];
          x_[found] = static_cast<Real>(seen.x()), y_[found] = static_cast<Real>(seen.y());
          z_[found] = static_cast<Real>(seen.z());
          to_[found] = column + which_[k], who_[found] = leaf.begin + which_[k];
        }
      }
      loops.triangle_potential(frames_[s], x_.data(), y_.data(), z_.data(), found, integral_.data());
      for (int k = 0; k < found; ++k) *to_[k] = integral_[k];
      // None but a triangle's own centroid feels it so much, unless it lies over it or the triangle is a sliver.
      const Real much = Real(0.75) * *std::max_element(integral_.begin(), integral_.begin() + found);
      for (int k = 0; k < found && !thin_gap_; ++k) thin_gap_ = integral_[k] > much && FacesClosely(s, who_[k]);
      total += found;
    }
    return total;
  }

  bool thin_gap() const { return thin_gap_; }  // met so far

 private:
  // Whether the triangle at a place of the tree's order lies over source triangle s, face to face and so near that
  // single precision hardly tells the two apart.
  bool FacesClosely(int s, int place) const {
    constexpr double kThin = 0.006, kCoincident = 1e-12;  // diameters; what coincides no precision tells apart
    const int triangle = tree_.order[source_->begin + s], other = tree_.order[place];
    if (triangle == other) return false;
    const TriangleFrame frame = FrameOf(mesh_, triangle);
    using Map = Eigen::Map<const Eigen::Vector3d>;
    const double height = std::abs(Map(frame.normal).dot(points_.place[place] - Map(frame.vertex[0])));
    const double diameter = panels_.diameter[triangle];
    if (height > kThin * diameter || height < kCoincident * diameter) return false;
    for (int e = 0; e < 3; ++e) {
      if (Map(frame.outward[e]).dot(points_.place[place] - Map(frame.vertex[e])) > 0.0) return false;
    }
    return std::abs(Map(frame.normal).dot(Map(FrameOf(mesh_, other).normal))) > 0.9;
  }

  static constexpr int kPointCounts[3] = {1, 3, 7};
  // A rule's points on all triangles of the leaf, seen from its centre, with their shares of the area.
  struct Points {
    std::vector<Real> x, y, z, weight;
    void Add(std::span<const RulePoint> rule, const TriangleMesh& mesh, int triangle, const Eigen::Vector3d& origin,
             double area) {
      for (const RulePoint& point : rule) {
        const Eigen::Vector3d place = PlaceOf(point, mesh, triangle) - origin;
        x.push_back(static_cast<Real>(place.x())), y.push_back(static_cast<Real>(place.y()));
        z.push_back(static_cast<Real>(place.z())), weight.push_back(static_cast<Real>(point.share * area));
      }
    }
  };

  const TriangleMesh& mesh_;
  const Panels& panels_;
  const Tree& tree_;
  const LeafPoints<Real>& points_;
  const NearRule& rule_;
  const Kernels& kernels_;
  const Cell* source_ = nullptr;
  std::vector<TriangleFrameOf<Real>> frames_;  // each seen from its centroid
  std::vector<Eigen::Vector3d> centroid_;
  std::vector<double> reach_;
  double largest_ = 0.0;  // diameter
  std::array<Points, 3> rules_;
  std::vector<Real> x_, y_, z_, integral_;
  std::vector<Real*> to_;
  std::vector<int> which_, who_;
  bool thin_gap_ = false;
  std::vector<Target> close_;  // leaves with points within reach of some triangle of the source
};

}  // namespace

template <typename Real>
NearField<Real>::NearField(const TriangleMesh& mesh, const Panels& panels, const Tree& tree, const SourceLists& near,
                           const NearRule& rule, int threads, const Kernels& kernels)
    : tree_(tree), near_(near), kernels_(kernels), block_begin_(near.source.size()) {
  const std::size_t leaves = tree.leaves.size();
  for (std::size_t target = 0; target < leaves; ++target) {
    const auto rows = static_cast<std::size_t>(tree.cells[tree.leaves[target]].count());
    for (std::size_t pair = near.begin[target]; pair < near.begin[target + 1]; ++pair) {
      block_begin_[pair] = value_count_;
      value_count_ += rows * tree.cells[tree.leaves[near.source[pair]]].count();
    }
  }
  values_ = MakeLargeArray<Real>(value_count_ + kPadding);
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
  std::atomic<std::size_t> exact_pairs{0};
  std::atomic<bool> thin_gap{false};
  ParallelFor((static_cast<std::ptrdiff_t>(leaves) + kSources - 1) / kSources, threads, 1, [&](std::ptrdiff_t task) {
    ColumnFiller<Real> filler(mesh, panels, tree, points, rule, kernels);
    std::vector<typename ColumnFiller<Real>::Target> targets;
    const std::size_t end = std::min<std::size_t>(leaves, (task + 1) * kSources);
    for (std::size_t source = task * kSources; source < end; ++source) {
      filler.SetSource(tree.cells[tree.leaves[source]]);
      targets.clear();
      for (std::size_t i = begin[source]; i < begin[source + 1]; ++i) {
        const auto& [target, pair] = by_source[i];
        targets.push_back(
            {static_cast<std::size_t>(target), &tree.cells[tree.leaves[target]], &values_[block_begin_[pair]]});
        filler.Fill(targets.back().leaf_place, *targets.back().leaf, targets.back().values);
      }
      exact_pairs += filler.FillExact(targets);
    }
    if (filler.thin_gap()) thin_gap = true;
  });
  exact_pairs_ = exact_pairs;
  thin_gap_ = thin_gap;
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
