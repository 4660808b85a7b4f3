// SPDX-License-Identifier: Apache-2.0
#include "core/parts/unseen_cuts.h"

#include <set>

#include <gtest/gtest.h>

#include "core/parts/part_surface.h"

namespace geond {
namespace {

// A strip of unit squares, two triangles each, in the plane: column by column of `rows`.
TriangleMesh Strip(int squares, int rows = 1) {
  TriangleMesh mesh;
  for (int i = 0; i <= squares; ++i) {
    for (int j = 0; j <= rows; ++j) mesh.vertices.push_back({double(i), double(j), 0});
  }
  for (int i = 0; i < squares; ++i) {
    for (int j = 0; j < rows; ++j) {
      const int at = i * (rows + 1) + j, right = at + rows + 1;
      mesh.triangles.push_back({at, right, right + 1});
      mesh.triangles.push_back({at, right + 1, at + 1});
    }
  }
  return mesh;
}

// Labels 0, 1, 2 for the thirds of a strip of 12 squares, in the order of the surface's triangles.
struct ThreeParts {
  PartSurface surface = MakePartSurface(Strip(12), 0.0);
  std::vector<int> labels;
  std::vector<std::uint8_t> seen;
  ThreeParts() {
    for (int t = 0; t < surface.n(); ++t) {
      labels.push_back(surface.source[t] / 8);
      seen.push_back(1);
    }
  }
  void Hide(int from, int to) {
    for (int t = 0; t < surface.n(); ++t) {
      if (surface.source[t] >= from && surface.source[t] < to) seen[t] = 0;
    }
  }
  std::vector<int> Joined() {
    JoinOverUnseen(surface.graph, seen, labels);
    std::vector<int> by_source(labels.size());
    for (int t = 0; t < surface.n(); ++t) by_source[surface.source[t]] = labels[t];
    return by_source;
  }
};

TEST(JoinOverUnseen, LeavesWhatWasSeen) {
  ThreeParts parts;
  const std::vector<int> joined = parts.Joined();
  for (int t = 0; t < 24; ++t) EXPECT_EQ(joined[t], t / 8);
}

TEST(JoinOverUnseen, JoinsOverACutInTheDark) {
  ThreeParts parts;
  parts.Hide(4, 12);  // four triangles on either side of the first cut
  const std::vector<int> joined = parts.Joined();
  EXPECT_EQ(joined[0], joined[8]);
  EXPECT_NE(joined[8], joined[23]);
}

TEST(JoinOverUnseen, KeepsACutThatRunsCloseToSeenSurface) {
  ThreeParts parts;
  parts.Hide(7, 9);
  const std::vector<int> joined = parts.Joined();
  EXPECT_NE(joined[0], joined[8]);
}

TEST(JoinOverUnseen, APartHardlySeenJoinsANeighbour) {
  ThreeParts parts;
  parts.Hide(9, 15);  // all of the middle part but its rims, so that both its cuts are near seen surface
  parts.seen.assign(parts.seen.size(), 1);
  parts.Hide(8, 16);
  const std::vector<int> joined = parts.Joined();
  EXPECT_TRUE(joined[8] == joined[0] || joined[8] == joined[23]);
}

// One view: of every cut the half is seen that faces the sensor; that does not speak against it. But one in the dark goes.
TEST(JoinOverUnseen, HalfACutIsEnoughWhereHalfOfAllWasSeen) {
  constexpr int kColumns = 18, kRows = 12;
  const PartSurface surface = MakePartSurface(Strip(kColumns, kRows), 0.0);
  std::vector<int> labels(surface.n());
  std::vector<std::uint8_t> seen(surface.n());
  for (int t = 0; t < surface.n(); ++t) {
    const int column = surface.source[t] / (2 * kRows), row = surface.source[t] / 2 % kRows;
    labels[t] = column / 6;
    seen[t] = row < (column < 9 ? 6 : 0);  // round the second cut nothing was seen
  }
  JoinOverUnseen(surface.graph, seen, labels);
  std::set<int> left, right;
  for (int t = 0; t < surface.n(); ++t) (surface.source[t] / (2 * kRows) < 6 ? left : right).insert(labels[t]);
  EXPECT_EQ(left.size(), 1u);
  EXPECT_EQ(right.size(), 1u);
  EXPECT_NE(left, right);
}

}  // namespace
}  // namespace geond
