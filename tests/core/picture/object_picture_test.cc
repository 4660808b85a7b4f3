// SPDX-License-Identifier: Apache-2.0
#include "core/picture/object_picture.h"

#include <cmath>
#include <stdexcept>

#include <gtest/gtest.h>

#include "core/picture/stroke_font.h"

namespace geond {
namespace {

// A torus of two halves.
ObjectPictureData Torus() {
  ObjectPictureData data;
  constexpr int kAround = 24, kAcross = 12;
  for (int i = 0; i < kAround; ++i) {
    for (int j = 0; j < kAcross; ++j) {
      const double u = 2 * M_PI * i / kAround, v = 2 * M_PI * j / kAcross, r = 0.05 + 0.02 * std::cos(v);
      data.mesh.vertices.push_back({r * std::cos(u), r * std::sin(u), 0.02 * std::sin(v)});
      const int a = i * kAcross + j, b = (i + 1) % kAround * kAcross + j;
      const int c = i * kAcross + (j + 1) % kAcross, d = (i + 1) % kAround * kAcross + (j + 1) % kAcross;
      data.mesh.triangles.push_back({a, b, d});
      data.mesh.triangles.push_back({a, d, c});
      for (int k = 0; k < 2; ++k) {
        data.labels.push_back(i < kAround / 2 ? 0 : 1);
        data.charge.push_back(1.0 + 0.5 * std::cos(v));
      }
    }
  }
  data.cloud.points = data.mesh.vertices;
  data.cloud.normals = VertexNormals(data.mesh);
  data.geons.push_back({data.mesh, "1 curved cylinder"});
  data.title = "torus";
  return data;
}

ObjectPictureOptions Small() {
  ObjectPictureOptions options;
  options.columns = 400;
  options.samples = 1;
  return options;
}

int Inked(const Image& image) {
  int n = 0;
  for (int row = 0; row < image.rows; ++row) {
    for (int column = 0; column < image.columns; ++column) n += image.at(column, row).minCoeff() < 0.9f;
  }
  return n;
}

TEST(ObjectPicture, ShowsAPanelForWhatIsKnown) {
  const ObjectPictureData all = Torus();
  const Image image = ObjectPicture(all, Small());
  EXPECT_EQ(image.columns, 400);
  EXPECT_EQ(image.rgb.size(), 3u * image.columns * image.rows);
  EXPECT_GT(Inked(image), 10000);
  ObjectPictureData cloud;
  cloud.cloud = all.cloud;
  EXPECT_GT(Inked(ObjectPicture(cloud, Small())), 5000);
  ObjectPictureData mesh;
  mesh.mesh = all.mesh;
  EXPECT_GT(Inked(ObjectPicture(mesh, Small())), 5000);
}

TEST(ObjectPicture, KeepsTheSizeAskedFor) {
  ObjectPictureOptions options = Small();
  options.rows = 300;
  const Image image = ObjectPicture(Torus(), options);
  EXPECT_EQ(image.columns, 400);
  EXPECT_EQ(image.rows, 300);
}

TEST(ObjectPicture, IsTheSameForAnyNumberOfThreads) {
  ObjectPictureOptions options = Small();
  options.threads = 1;
  const Image one = ObjectPicture(Torus(), options);
  options.threads = 3;
  EXPECT_EQ(ObjectPicture(Torus(), options).rgb, one.rgb);
}

TEST(ObjectPicture, PartsHaveTheirColors) {
  ObjectPictureOptions options = Small();
  options.panels = {Panel::kParts};
  const Image image = ObjectPicture(Torus(), options);
  int first = 0, second = 0;
  for (int row = 0; row < image.rows; ++row) {
    for (int column = 0; column < image.columns; ++column) {
      const Color c = image.at(column, row);
      if (c.maxCoeff() - c.minCoeff() < 0.2f) continue;
      ((PartColor(0) - c).norm() < (PartColor(1) - c).norm() ? first : second) += 1;
    }
  }
  EXPECT_GT(first, 2000);
  EXPECT_GT(second, 2000);
}

TEST(ObjectPicture, RefusesWhatDoesNotFitTogether) {
  EXPECT_THROW(ObjectPicture({}, Small()), std::invalid_argument);
  ObjectPictureData data = Torus();
  data.labels.pop_back();
  EXPECT_THROW(ObjectPicture(data, Small()), std::invalid_argument);
  ObjectPictureOptions tiny = Small();
  tiny.columns = 3;
  EXPECT_THROW(ObjectPicture(Torus(), tiny), std::invalid_argument);
}

TEST(ObjectPicture, APanelWithoutDataStaysEmpty) {
  ObjectPictureData data = Torus();
  data.charge.clear();
  ObjectPictureOptions options = Small();
  options.panels = {Panel::kCharge, Panel::kParts};
  EXPECT_NO_THROW(ObjectPicture(data, options));
}

TEST(PanelFromName, KnowsAllAndNamesThem) {
  EXPECT_EQ(PanelFromName("cloud"), Panel::kCloud);
  EXPECT_EQ(PanelFromName("geons"), Panel::kGeons);
  EXPECT_THROW(PanelFromName("everything"), std::invalid_argument);
}

TEST(StrokeFont, EveryPrintableCharacterHasStrokesWithinItsBox) {
  for (char c = '!'; c <= '~'; ++c) {
    const std::string text(1, c);
    const std::vector<Stroke> strokes = TextStrokes(text);
    EXPECT_FALSE(strokes.empty()) << c;
    for (const Stroke& stroke : strokes) {
      EXPECT_GE(stroke.size(), 2u);
      for (const Eigen::Vector2d& p : stroke) {
        EXPECT_GE(p.x(), 0.0) << c;
        EXPECT_LE(p.x(), TextWidth(text) + 1e-9) << c;
        EXPECT_GE(p.y(), 0.0) << c;
        EXPECT_LE(p.y(), 8.0) << c;
      }
    }
  }
  EXPECT_EQ(TextWidth(""), 0.0);
  EXPECT_GT(TextWidth("two words"), TextWidth("two"));
  EXPECT_EQ(TextStrokes("\xff\xc2").size(), 2u);  // no UTF-8: boxes
}

}  // namespace
}  // namespace geond
