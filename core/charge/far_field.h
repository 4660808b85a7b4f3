// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/charge/kernels.h"
#include "core/charge/quadrature.h"
#include "core/charge/source_lists.h"
#include "core/charge/tree.h"

namespace geond::charge {

// The potential of the far pairs by multipoles: up the tree, across, and down again (Greengard and Rokhlin 1987). The step
// across is a product of a small matrix with as many vectors as there are pairs of cells at that distance, taken together;
// reflections leave one matrix for eight distances. Triangles are counted in the tree's order.
template <typename Real>
class FarField {
 public:
  // `rule` says which points stand for a triangle in the multipoles.
  FarField(const TriangleMesh& mesh, const Panels& panels, const Tree& tree, const SourceLists& far, int order,
           std::span<const RulePoint> rule, int threads, const Kernels& kernels);

  // Takes in the densities x; AddPotential then has their far potential.
  void Spread(std::span<const Real> x);

  // potential[i] += the far potential at the triangles i = 0, 1, ... of a leaf; potential is padded.
  void AddPotential(int leaf, Real* potential) const;

  std::size_t bytes() const;
  std::size_t matrices() const { return across_.size() / matrix_size(); }

 private:
  // One matrix and the pairs it serves, one after another in pairs_.
  struct Batch {
    int matrix;
    int begin, end;
  };
  std::size_t matrix_size() const { return static_cast<std::size_t>(count_) * stride_; }
  void PlacePoints(const TriangleMesh& mesh, const Panels& panels);
  void MakeShifts();
  void MakeBatches(const SourceLists& far);
  void Gather(std::span<const Real> x);
  void Across();
  void Scatter();

  const Tree& tree_;
  const Kernels& kernels_;
  std::span<const RulePoint> rule_;
  int order_, count_, stride_, threads_;

  std::vector<std::size_t> leaf_points_;  // of each leaf into the points, in padded counts
  std::vector<Real> point_x_, point_y_, point_z_;     // of the rule, in half sides from the leaf's centre
  std::vector<Real> centroid_x_, centroid_y_, centroid_z_, area_;

  std::array<std::vector<Real>, 8> up_, down_;  // by the child's octant
  std::vector<Real> across_;                    // all matrices, one after another
  std::array<std::vector<Real>, 8> signs_;      // by reflection
  std::vector<CellPair> pairs_;
  std::vector<Batch> batches_;
  std::vector<int> group_begin_;  // batches of a group of targets; groups are served side by side
  std::vector<int> group_cells_;  // cells of group g: from group_cells_[g] to group_cells_[g + 1]

  std::vector<Real> multipoles_, locals_;  // a vector of stride_ for each cell
};

extern template class FarField<float>;
extern template class FarField<double>;

}  // namespace geond::charge
