// SPDX-License-Identifier: Apache-2.0
#include "core/charge/source_lists.h"

#include <algorithm>

#include "core/base/parallel.h"

namespace geond::charge {

SourceLists SortByTarget(const std::vector<std::pair<int, int>>& pairs, std::size_t targets, int threads) {
  SourceLists lists;
  lists.begin.assign(targets + 1, 0);
  for (const auto& [target, source] : pairs) ++lists.begin[target + 1];
  for (std::size_t t = 0; t < targets; ++t) lists.begin[t + 1] += lists.begin[t];
  lists.source.resize(pairs.size());
  std::vector<std::size_t> next(lists.begin.begin(), lists.begin.end() - 1);
  for (const auto& [target, source] : pairs) lists.source[next[target]++] = source;
  ParallelFor(static_cast<std::ptrdiff_t>(targets), threads, 1024, [&](std::ptrdiff_t t) {
    std::sort(lists.source.begin() + lists.begin[t], lists.source.begin() + lists.begin[t + 1]);
  });
  return lists;
}

}  // namespace geond::charge
