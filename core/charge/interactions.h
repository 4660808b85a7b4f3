// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include "core/charge/source_lists.h"
#include "core/charge/tree.h"

namespace geond::charge {

// Who acts on whom, and how: every pair of triangles is either near, by way of two leaves, or far, by way of two cells
// that hold them.
struct Interactions {
  SourceLists near;  // places among the leaves
  SourceLists far;   // places among the cells
};

// When two cells are far: when both the source's multipoles and the target's local terms converge by a ratio of at most
// `steepest` a degree, and there are at least `least_work` pairs of triangles between them (fewer are cheaper one by
// one).
struct FarRule {
  double steepest = 0.53;
  std::ptrdiff_t least_work = 64;
};

constexpr int kMostLevelsApart = 16;

// A dual traversal of the tree. Cells more than kMostLevelsApart levels apart are never far.
Interactions FindInteractions(const Tree& tree, const FarRule& rule, int threads);

}  // namespace geond::charge
