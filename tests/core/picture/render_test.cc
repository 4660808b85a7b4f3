// SPDX-License-Identifier: Apache-2.0
#include "core/picture/render.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <stdexcept>

#include <gtest/gtest.h>

#include "core/base/error.h"

namespace geond {
namespace {

TriangleMesh Box(const Eigen::Vector3d& low, const Eigen::Vector3d& high) {
  TriangleMesh mesh;
  for (int i = 0; i < 8; ++i) {
    mesh.vertices.push_back({i & 1 ? high.x() : low.x(), i & 2 ? high.y() : low.y(), i & 4 ? high.z() : low.z()});
  }
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return mesh;
}

RenderOptions Plain(int columns = 120, int rows = 100) {
  RenderOptions options;
  options.columns = columns;
  options.rows = rows;
  options.samples = 1;
  options.ground_shadow = false;
  options.occlusion = false;
  return options;
}

MeshStyle Painted(const Color& color) {
  MeshStyle style;
  style.color = color;
  style.outline = false;
  return style;
}

bool IsRed(const Color& c) { return c.x() > 1.5f * c.y() && c.x() > 1.5f * c.z(); }
bool IsGreen(const Color& c) { return c.y() > 1.5f * c.x() && c.y() > 1.5f * c.z(); }
bool IsWhite(const Color& c) { return c.minCoeff() > 0.99f; }

TEST(Framing, FillsThePictureAndNothingLeavesIt) {
  for (double aspect : {0.5, 1.0, 2.0}) {
    for (double azimuth : {0.0, 0.7, 3.0}) {
      Scene scene;
      scene.Add(Box({-0.02, 0.01, 0.0}, {0.05, 0.03, 0.12}), Painted({0.8f, 0.1f, 0.1f}));
      const RenderOptions options = Plain(static_cast<int>(120 * aspect), 120);
      const Image image = Render(scene, Framing({&scene}, azimuth, 0.4, aspect, 0.05), options);
      int left = image.columns, right = -1, top = image.rows, bottom = -1;
      for (int row = 0; row < image.rows; ++row) {
        for (int column = 0; column < image.columns; ++column) {
          if (IsWhite(image.at(column, row))) continue;
          left = std::min(left, column), right = std::max(right, column), top = std::min(top, row),
          bottom = std::max(bottom, row);
        }
      }
      EXPECT_GT(left, 0);
      EXPECT_GT(top, 0);
      EXPECT_LT(right, image.columns - 1);
      EXPECT_LT(bottom, image.rows - 1);
      const double fill = std::max((right - left + 1.0) / image.columns, (bottom - top + 1.0) / image.rows);
      EXPECT_GT(fill, 0.86);
      EXPECT_LT(fill, 0.94);
    }
  }
  EXPECT_THROW(Framing({}, 0, 0, 1.0), std::invalid_argument);
}

TEST(Render, WhatIsNearerHidesWhatIsFarther) {
  // Seen along -x: the red box stands before the lower half of the green one.
  Scene scene;
  scene.Add(Box({0.0, -0.05, 0.0}, {0.01, 0.05, 0.1}), Painted({0.1f, 0.8f, 0.1f}));
  scene.Add(Box({0.03, -0.05, 0.0}, {0.04, 0.05, 0.05}), Painted({0.8f, 0.1f, 0.1f}));
  for (bool swapped : {false, true}) {
    if (swapped) std::swap(scene.meshes[0], scene.meshes[1]);
    const Image image = Render(scene, Framing({&scene}, 0.0, 0.0, 1.0), Plain(100, 100));
    EXPECT_TRUE(IsRed(image.at(50, 75)));
    EXPECT_TRUE(IsGreen(image.at(50, 25)));
    EXPECT_TRUE(IsWhite(image.at(1, 1)));
  }
}

TEST(Render, RightIsRightAndUpIsUp) {
  // The eye on the x axis looks along -x: y runs to the right, z up.
  Scene scene;
  scene.Add(Box({-0.01, -0.05, 0.0}, {0.01, -0.02, 0.1}), Painted({0.8f, 0.1f, 0.1f}));
  scene.Add(Box({-0.01, 0.02, 0.0}, {0.01, 0.05, 0.03}), Painted({0.1f, 0.8f, 0.1f}));
  const Image image = Render(scene, Framing({&scene}, 0.0, 0.0, 1.0), Plain(100, 100));
  EXPECT_TRUE(IsRed(image.at(15, 20)));
  EXPECT_TRUE(IsGreen(image.at(85, 85)));
  EXPECT_TRUE(IsWhite(image.at(85, 20)));
}

TEST(Render, GlassShowsWhatIsBehindIt) {
  Scene scene;
  scene.Add(Box({0.0, -0.05, 0.0}, {0.01, 0.05, 0.1}), Painted({0.1f, 0.8f, 0.1f}));
  MeshStyle glass = Painted({0.8f, 0.1f, 0.1f});
  glass.opacity = 0.3;
  scene.Add(Box({0.03, -0.05, 0.0}, {0.04, 0.05, 0.1}), glass);
  const Image image = Render(scene, Framing({&scene}, 0.0, 0.0, 1.0), Plain(100, 100));
  const Color through = image.at(50, 50);
  EXPECT_GT(through.y(), through.x());  // more of the green behind ...
  EXPECT_GT(through.x(), 0.3f);         // ... but red from the glass
}

TEST(Render, LinesAreHiddenBySurfacesAndSeenOnThem) {
  Scene scene;
  scene.Add(Box({0.0, -0.05, 0.0}, {0.02, 0.05, 0.1}), Painted({0.9f, 0.9f, 0.9f}));
  LineStyle style;
  style.color = {1.0f, 0.0f, 0.0f};
  style.width = 3.0;
  scene.Add({{{0.02, -0.05, 0.075}, {0.02, 0.05, 0.075}}, {{-0.02, -0.05, 0.025}, {-0.02, 0.05, 0.025}}}, style);
  const Image image = Render(scene, Framing({&scene}, 0.0, 0.0, 1.0), Plain(100, 100));
  EXPECT_TRUE(IsRed(image.at(50, 27)) || IsRed(image.at(50, 28)) || IsRed(image.at(50, 26)));
  int red_below = 0;
  for (int row = 50; row < 100; ++row) red_below += IsRed(image.at(50, row));
  EXPECT_EQ(red_below, 0);
}

TEST(Render, PointsHaveTheirColors) {
  PointCloud cloud;
  CloudStyle style;
  for (int i = 0; i < 400; ++i) {
    cloud.points.push_back({0.0, 0.005 * (i % 20), 0.005 * (i / 20)});
    style.point_colors.push_back(i % 20 < 10 ? Color(0.8f, 0.1f, 0.1f) : Color(0.1f, 0.8f, 0.1f));
  }
  for (bool normals : {false, true}) {
    if (normals) cloud.normals.assign(cloud.size(), Eigen::Vector3d::UnitX());
    Scene scene;
    scene.Add(cloud, style);
    const Image image = Render(scene, Framing({&scene}, 0.0, 0.0, 1.0), Plain(100, 100));
    int red = 0, green = 0;
    for (int row = 10; row < 90; ++row) {
      for (int column = 10; column < 90; ++column) {
        red += column < 48 && IsRed(image.at(column, row));
        green += column > 52 && IsGreen(image.at(column, row));
        EXPECT_FALSE(column < 45 && IsGreen(image.at(column, row)));
      }
    }
    EXPECT_GT(red, 2000);
    EXPECT_GT(green, 2000);
  }
}

TEST(Render, CornersAreDarkerThanOpenSurfaces) {
  Scene scene;
  scene.Add(Box({0.0, 0.0, 0.0}, {0.1, 0.1, 0.01}), Painted(Color::Constant(0.7f)));
  scene.Add(Box({0.0, 0.0, 0.01}, {0.01, 0.1, 0.1}), Painted(Color::Constant(0.7f)));
  RenderOptions options = Plain(200, 200);
  const Camera camera = Framing({&scene}, 0.0, 0.6, 1.0);
  const Image flat = Render(scene, camera, options);
  options.occlusion = true;
  const Image deep = Render(scene, camera, options);
  double largest_change = 0.0, sum = 0.0;
  for (int row = 0; row < 200; ++row) {
    const double change = flat.at(100, row).x() - deep.at(100, row).x();
    EXPECT_GE(change, -0.05);
    largest_change = std::max(largest_change, change);
    sum += change;
  }
  EXPECT_GT(largest_change, 0.08);             // in the fold
  EXPECT_LT(sum / 200, 0.5 * largest_change);  // not everywhere
}

TEST(Render, GivesTheSameBitsForAnyNumberOfThreads) {
  Scene scene;
  scene.Add(Box({-0.02, 0.01, 0.0}, {0.05, 0.03, 0.12}));
  PointCloud cloud;
  for (int i = 0; i < 500; ++i) cloud.points.push_back({0.001 * (i % 7), 0.002 * (i % 31), 0.001 * (i % 101)});
  scene.Add(cloud);
  scene.AddLabel({0, 0, 0.1}, "a label");
  RenderOptions options;
  options.columns = 150;
  options.rows = 130;
  options.axes = options.scale_bar = true;
  options.threads = 1;
  const Camera camera = Framing({&scene}, 0.5, 0.4, 150.0 / 130.0);
  const Image one = Render(scene, camera, options);
  for (int threads : {2, 5}) {
    options.threads = threads;
    EXPECT_EQ(Render(scene, camera, options).rgb, one.rgb);
  }
}

TEST(Render, RefusesWhatCannotBe) {
  Scene scene;
  scene.Add(Box({0, 0, 0}, {1, 1, 1}));
  const Camera camera = Framing({&scene}, 0.5, 0.4, 1.0);
  EXPECT_THROW(Render(scene, camera, Plain(5, 100)), std::invalid_argument);
  scene.meshes[0].style.triangle_colors.resize(3);
  EXPECT_THROW(Render(scene, camera, Plain()), std::invalid_argument);
  scene.meshes[0].style.triangle_colors.clear();
  scene.meshes[0].mesh.triangles[0][0] = 99;
  EXPECT_THROW(Render(scene, camera, Plain()), std::invalid_argument);
}

TEST(Segments, OfABoxAreItsEdges) {
  const TriangleMesh box = Box({0, 0, 0}, {1, 1, 1});
  EXPECT_EQ(CreaseSegments(box).size(), 12u);
  EXPECT_EQ(WireSegments(box).size(), 18u);
  std::vector<int> labels(12, 0);
  labels[2] = labels[3] = 1;  // the top
  EXPECT_EQ(BorderSegments(box, labels).size(), 4u);
  EXPECT_THROW(BorderSegments(box, {0, 1}), std::invalid_argument);
}

TEST(WritePng, WritesAPngOrSaysWhyNot) {
  Image image{16, 16, std::vector<std::uint8_t>(3 * 256, 77)};
  const auto path = std::filesystem::path(testing::TempDir()) / "geond_write_png_test.png";
  WritePng(image, path);
  std::ifstream file(path, std::ios::binary);
  std::string magic(8, '\0');
  file.read(magic.data(), 8);
  EXPECT_EQ(magic, "\x89PNG\r\n\x1a\n");
  std::filesystem::remove(path);
  EXPECT_THROW(WritePng(image, "/no/such/folder/a.png"), FileError);
}

}  // namespace
}  // namespace geond
