// SPDX-License-Identifier: Apache-2.0
#include "core/picture/color.h"

#include <cmath>

#include <gtest/gtest.h>

namespace geond {
namespace {

TEST(Color, LightAndBack) {
  for (float c = 0.0f; c <= 1.0f; c += 0.05f) {
    const Color color(c, 1.0f - c, 0.5f * c);
    EXPECT_LT((FromLight(ToLight(color)) - color).norm(), 1e-5f);
  }
}

TEST(Color, GreysHaveNoHue) {
  for (double lightness : {0.0, 0.3, 0.7, 1.0}) {
    const Color grey = ColorFromLightness(lightness, 0.0, 1.0);
    EXPECT_NEAR(grey.x(), grey.y(), 2e-3);
    EXPECT_NEAR(grey.y(), grey.z(), 2e-3);
  }
  EXPECT_NEAR(ColorFromLightness(1.0, 0.0, 0.0).x(), 1.0, 1e-3);
}

TEST(DivergingColor, IsBlueBelowRedAboveAndDarkerOutwards) {
  EXPECT_GT(DivergingColor(-1).z(), 2.0f * DivergingColor(-1).x());
  EXPECT_GT(DivergingColor(1).x(), 2.0f * DivergingColor(1).z());
  EXPECT_GT(DivergingColor(0).minCoeff(), 0.9f);
  EXPECT_EQ(DivergingColor(7), DivergingColor(1));
  float before = 2.0f;
  for (double v = 0.0; v <= 1.0; v += 0.05) {
    const float light = ToLight(DivergingColor(v)).dot(Color(0.2126f, 0.7152f, 0.0722f));
    EXPECT_LT(light, before);
    before = light;
  }
}

TEST(PartColor, NeighborsDiffer) {
  for (int i = 0; i < 12; ++i) {
    for (int j = 0; j < i; ++j) EXPECT_GT((PartColor(i) - PartColor(j)).norm(), 0.08f) << i << " " << j;
  }
}

}  // namespace
}  // namespace geond
