// SPDX-License-Identifier: Apache-2.0
#include "calib/speckles.h"

#include <algorithm>

#include <gtest/gtest.h>

namespace geond::calib {
namespace {

// A view of 20 x 20 pixels with a square of object pixels of `side` at (2, 2).
RangeView ViewWithSquare(int side) {
  RangeView view;
  view.image = {20, 20, std::vector<float>(400, 1.0f)};
  view.classes.assign(400, PixelClass::kTable);
  for (int row = 2; row < 2 + side; ++row) {
    for (int column = 2; column < 2 + side; ++column) view.classes[view.image.index(column, row)] = PixelClass::kObject;
  }
  return view;
}

long ObjectPixels(const RangeView& view) { return std::count(view.classes.begin(), view.classes.end(), PixelClass::kObject); }

TEST(RejectSpeckles, KeepsALargeGroupAndRejectsASmallOne) {
  RangeView view = ViewWithSquare(4);
  view.classes[view.image.index(15, 15)] = view.classes[view.image.index(16, 16)] = PixelClass::kObject;
  RejectSpeckles(view);
  EXPECT_EQ(ObjectPixels(view), 16);
  EXPECT_EQ(view.classes[view.image.index(15, 15)], PixelClass::kRejected);
  EXPECT_EQ(view.classes[view.image.index(10, 10)], PixelClass::kTable);
}

TEST(RejectSpeckles, CornersHangTogether) {
  RangeView view = ViewWithSquare(0);
  for (int i = 0; i < 12; ++i) view.classes[view.image.index(i, i)] = PixelClass::kObject;
  RejectSpeckles(view, 12);
  EXPECT_EQ(ObjectPixels(view), 12);
  RejectSpeckles(view, 13);
  EXPECT_EQ(ObjectPixels(view), 0);
}

}  // namespace
}  // namespace geond::calib
