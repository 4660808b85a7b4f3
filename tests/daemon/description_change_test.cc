// SPDX-License-Identifier: Apache-2.0
#include "daemon/command/description_change.h"

#include <gtest/gtest.h>

namespace geond::daemon {
namespace {

Json Part(int id, const std::string& type, double x, double size, const Json& deviation = 0.2) {
  return {{"id", id}, {"type", type}, {"pose", {{"position_mm", {x, 0, 10}}}}, {"size_mm", {size, size, 20}},
          {"deviation", {{"size_mm", {deviation, deviation, 0.2}}}}};
}

Json Two(const Json& a, const Json& b) { return {{"n_parts", 2}, {"parts", {a, b}}}; }

TEST(WhatChanged, IsNothingWithinDeviationsAndWhateverTheOrder) {
  const Json before = Two(Part(1, "cylinder", 0, 30), Part(2, "cuboid", 50, 12));
  EXPECT_EQ(WhatChanged(before, before), "");
  EXPECT_EQ(WhatChanged(before, Two(Part(1, "cuboid", 50.2, 12.3), Part(2, "cylinder", 0.1, 30.5))), "");
}

TEST(WhatChanged, NamesPartsTypesAndSizes) {
  const Json before = Two(Part(1, "cylinder", 0, 30), Part(2, "cuboid", 50, 12));
  EXPECT_NE(WhatChanged(before, {{"n_parts", 3}, {"parts", Json::array()}}).find("3 parts, 2 before"), std::string::npos);
  EXPECT_NE(WhatChanged(before, Two(Part(1, "ellipsoid", 0, 30), Part(2, "cuboid", 50, 12))).find("as ellipsoid, before as cylinder"), std::string::npos);
  EXPECT_NE(WhatChanged(before, Two(Part(1, "cylinder", 0, 33), Part(2, "cuboid", 50, 12))).find("33.0"), std::string::npos);
}

TEST(WhatChanged, WhatNobodyKnewBeforeIsNewsAndWhatNobodyKnowsIsNot) {
  const Json unknown = Two(Part(1, "cylinder", 0, 30, nullptr), Part(2, "cuboid", 50, 12));
  const Json known = Two(Part(1, "cylinder", 0, 30), Part(2, "cuboid", 50, 12));
  EXPECT_NE(WhatChanged(unknown, known).find("known now"), std::string::npos);
  EXPECT_EQ(WhatChanged(unknown, Two(Part(1, "cylinder", 0, 44, nullptr), Part(2, "cuboid", 50, 12))), "");
}

}  // namespace
}  // namespace geond::daemon
