// SPDX-License-Identifier: Apache-2.0
#include "core/parts/min_cut.h"

#include <cstdint>
#include <limits>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace geond {
namespace {

struct Link {
  int u, v;
  std::int64_t capacity;
};

std::int64_t CutValue(const std::vector<Link>& links, const std::vector<bool>& at_source) {
  std::int64_t sum = 0;
  for (const Link& l : links) sum += at_source[l.u] != at_source[l.v] ? l.capacity : 0;
  return sum;
}

TEST(MinCut, CutsAPathAtItsWeakestLink) {
  MinCut cut(4);
  cut.Connect(0, 1, 5);
  cut.Connect(1, 2, 2);
  cut.Connect(2, 3, 7);
  cut.AttachToSource(0);
  cut.AttachToSink(3);
  EXPECT_EQ(cut.Solve(), (std::vector<bool>{true, true, false, false}));
}

TEST(MinCut, IsNoWorseThanAnyOtherCut) {
  std::mt19937_64 random(3);
  for (int round = 0; round < 50; ++round) {
    const int n = 9;
    std::vector<Link> links;
    for (int u = 0; u < n; ++u) {
      for (int v = u + 1; v < n; ++v) {
        if (random() % 2 == 0) links.push_back({u, v, static_cast<std::int64_t>(random() % 20)});
      }
    }
    MinCut cut(n);
    for (const Link& l : links) cut.Connect(l.u, l.v, l.capacity);
    cut.AttachToSource(0);
    cut.AttachToSink(n - 1);
    const std::vector<bool> found = cut.Solve();
    ASSERT_TRUE(found[0]);
    ASSERT_FALSE(found[n - 1]);
    std::int64_t best = std::numeric_limits<std::int64_t>::max();
    for (int mask = 0; mask < 1 << (n - 2); ++mask) {
      std::vector<bool> side(n, false);
      side[0] = true;
      for (int k = 1; k < n - 1; ++k) side[k] = mask >> (k - 1) & 1;
      best = std::min(best, CutValue(links, side));
    }
    EXPECT_EQ(CutValue(links, found), best);
  }
}

}  // namespace
}  // namespace geond
