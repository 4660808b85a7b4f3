// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

namespace geond::charge {

// Sources for each target: those of target t stand from begin[t] to begin[t + 1], in order.
struct SourceLists {
  std::vector<std::size_t> begin;
  std::vector<int> source;
};

// The lists of pairs (target, source), which may come in any order.
SourceLists SortByTarget(const std::vector<std::pair<int, int>>& pairs, std::size_t targets, int threads);

}  // namespace geond::charge
