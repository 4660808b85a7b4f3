// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "core/charge/panels.h"

namespace geond::charge {

// A cube of space and the triangles whose centroids lie in it.
struct Cell {
  int begin = 0, end = 0;                // places in the tree's order
  int first_child = -1, child_count = 0;  // places among the cells; none: a leaf
  int parent = -1;
  int level = 0;                          // the root's is 0
  std::array<std::int32_t, 3> corner{};   // in sides of this level's cells
  Eigen::Vector3d centre;                 // m
  double half_side = 0.0;                 // m
  double centroid_radius = 0.0;           // reach of the centroids from the centre, m
  double triangle_radius = 0.0;           // reach of the triangles, m
  bool is_leaf() const { return child_count == 0; }
  int count() const { return end - begin; }
};

// An octree over the centroids, as deep as the mesh is dense. Cells stand level by level, and within a level in the order
// of their triangles (Morton's), so that a cell's triangles are neighbours in memory.
struct Tree {
  std::vector<Cell> cells;
  std::vector<int> level_begin;  // level l has the cells from level_begin[l] to level_begin[l + 1]
  std::vector<int> leaves;       // places among the cells, in the order of their triangles
  std::vector<int> order;        // order[place] = triangle of the mesh
};

// Cells of more than `leaf_capacity` triangles are split, down to a fixed depth.
Tree BuildTree(const TriangleMesh& mesh, const Panels& panels, int leaf_capacity, int threads);

}  // namespace geond::charge
