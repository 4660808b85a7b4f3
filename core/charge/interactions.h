// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "core/charge/tree.h"

namespace geond::charge {

// Who acts on whom, and how: every pair of triangles is either near, by way of two leaves, or far, by way of two cells that
// hold them.
struct Interactions {
  // Sources for each target: those of target t stand from begin[t] to begin[t + 1], in order.
  struct Lists {
    std::vector<std::size_t> begin;
    std::vector<int> source;
  };
  Lists near;  // places among the leaves
  Lists far;   // places among the cells
};

constexpr int kMostLevelsApart = 16;

// A dual traversal of the tree. Two cells are far when centroid_radius + triangle_radius < theta * distance and their levels
// are no more than kMostLevelsApart apart; a far pair with fewer than `least_work` pairs of triangles counts as near all the same, which is cheaper.
Interactions FindInteractions(const Tree& tree, double theta, std::ptrdiff_t least_work);

}  // namespace geond::charge
