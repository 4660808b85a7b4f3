// SPDX-License-Identifier: Apache-2.0
#include "core/parts/unseen_cuts.h"

#include <gtest/gtest.h>

#include "core/parts/part_surface.h"

namespace geond {
namespace {

// A strip of unit squares, two triangles each, in the plane.
TriangleMesh Strip(int squares) {
  TriangleMesh mesh;
  for (int i = 0; i <= squares; ++i) {
    mesh.vertices.push_back({double(i), 0, 0});
    mesh.vertices.push_back({double(i), 1, 0});
  }
  for (int i = 0; i < squares; ++i) {
    mesh.triangles.push_back({2 * i, 2 * i + 2, 2 * i + 3});
    mesh.triangles.push_back({2 * i, 2 * i + 3, 2 * i + 1});
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

}  // namespace
}  // namespace geond
