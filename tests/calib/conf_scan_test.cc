// SPDX-License-Identifier: Apache-2.0
#include "calib/conf_scan.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>

#include <gtest/gtest.h>

#include "calib/grid_file.h"
#include "core/base/error.h"

namespace geond::calib {
namespace {

class ConfScan : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() /
              (std::string("geond_conf_") + testing::UnitTest::GetInstance()->current_test_info()->name());
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  void Write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name, std::ios::binary) << text;
  }

  // A bowl z = 2 x^2 + y / 10 on a grid of 1 mm, its rows upwards.
  std::string Bowl(int columns = 20, int rows = 16) const {
    std::string text = "ply\nformat ascii 1.0\nobj_info num_cols " + std::to_string(columns) + "\nobj_info num_rows " +
                       std::to_string(rows) + "\nelement vertex " + std::to_string(columns * rows) +
                       "\nproperty float x\nproperty float y\nproperty float z\nelement range_grid " +
                       std::to_string(columns * rows) + "\nproperty list uchar int vertex_indices\nend_header\n";
    for (int r = 0; r < rows; ++r) {
      for (int c = 0; c < columns; ++c) {
        const double x = (c - 10) * 1e-3, y = r * 1e-3;
        text += std::to_string(x) + " " + std::to_string(y) + " " + std::to_string(2 * x * x + 0.1 * y) + "\n";
      }
    }
    for (int k = 0; k < columns * rows; ++k) text += "1 " + std::to_string(k) + "\n";
    return text;
  }

  std::string Message(const std::string& conf) const {
    Write("scan.conf", conf);
    try {
      ReadConfScan(folder_ / "scan.conf");
    } catch (const FileError& error) {
      return error.what();
    }
    return "";
  }

  std::filesystem::path folder_;
};

TEST_F(ConfScan, PutsEveryPointWhereTheFileHasIt) {
  Write("bowl.ply", Bowl());
  // A quarter turn about z, of which the file gives the inverse: x of the grid becomes y.
  Write("scan.conf", "camera 0 0 0 0 0 0 1\n\nbmesh bowl.ply 0.5 0 0 0 0 -0.70710678 0.70710678\n");
  const RecordedScan scan = ReadConfScan(folder_ / "scan.conf");
  ASSERT_EQ(scan.views.size(), 1u);
  EXPECT_FALSE(scan.has_table);
  const auto& view = scan.views[0];
  EXPECT_EQ(view.sensor.columns, 20);
  EXPECT_EQ(view.sensor.rows, 16);
  int found = 0;
  for (int v = 0; v < view.sensor.rows; ++v) {
    for (int u = 0; u < view.sensor.columns; ++u) {
      const double depth = view.exposure.image.at(u, v);
      if (!std::isfinite(depth)) continue;
      ++found;
      const Eigen::Vector3d p = view.X_TS_measured * Unproject(view.sensor, u, v, depth);
      const double x = p.y(), y = 0.5 - p.x();
      EXPECT_NEAR(p.z(), 2 * x * x + 0.1 * y, 1e-6);
      EXPECT_LT(std::abs(x), 0.0101);
    }
  }
  EXPECT_GT(found, 300);
}

TEST_F(ConfScan, SaysWhatIsWrongAndWhere) {
  Write("bowl.ply", Bowl());
  EXPECT_NE(Message("bmesh bowl.ply 0 0 0 0 0 0\n").find("line 1"), std::string::npos);
  EXPECT_NE(Message("\nbmesh none.ply 0 0 0 0 0 0 1\n").find("none.ply"), std::string::npos);
  EXPECT_NE(Message("camera 0 0 0\n").find("no line"), std::string::npos);
  const std::string whole = Bowl();
  for (const std::size_t keep : {std::size_t{3}, std::size_t{80}, whole.size() / 2, whole.size() - 4}) {
    Write("bowl.ply", whole.substr(0, keep));
    EXPECT_FALSE(Message("bmesh bowl.ply 0 0 0 0 0 0 1\n").empty()) << keep;
  }
  std::string huge = whole;
  huge.replace(huge.find("vertex 320"), 10, "vertex 999999999");
  Write("bowl.ply", huge);
  EXPECT_NE(Message("bmesh bowl.ply 0 0 0 0 0 0 1\n").find("count"), std::string::npos);
  Write("bowl.ply", Bowl() .substr(0, whole.size() - 4) + "999\n");
  EXPECT_NE(Message("bmesh bowl.ply 0 0 0 0 0 0 1\n").find("vertex 999"), std::string::npos);
  std::filesystem::remove(folder_ / "bowl.ply");
  Write("bowl.ply.xz", "\xFD" "7zXZ no more");
  EXPECT_NE(Message("bmesh bowl.ply 0 0 0 0 0 0 1\n").find("xz"), std::string::npos);
}

TEST(ConfScanOfTheBunny, ReproducesTheRawPoints) {
  const char* data = std::getenv("GEOND_DATA");
  const std::filesystem::path folder =
      std::filesystem::path(data ? data : std::string(GEOND_SOURCE_DIR) + "/../shared/data") / "stanford_bunny_range";
  if (!std::filesystem::exists(folder / "bun.conf")) GTEST_SKIP() << "no bun.conf in " << folder << " (set GEOND_DATA)";
  const RecordedScan scan = ReadConfScan(folder / "bun.conf");
  ASSERT_EQ(scan.views.size(), 10u);
  for (const std::size_t k : {0u, 5u}) {  // bun000 and top2
    const auto& view = scan.views[k];
    const PointGrid grid = ReadGridFile(folder / (k == 0 ? "bun000.ply.xz" : "top2.ply.xz"));
    Eigen::Vector3d low = grid.points[0], high = low;
    for (const auto& p : grid.points) low = low.cwiseMin(p), high = high.cwiseMax(p);
    const Eigen::Matrix3d turn = Eigen::Vector3d(1, -1, -1).asDiagonal();
    const Pose X_SF = Inverse(Pose(turn, Eigen::Vector3d(low.x(), high.y(), high.z() + 0.05)));
    // Raw points against the four pixels around them, where those lie on one surface.
    std::vector<double> off;
    for (const auto& p : grid.points) {
      const Eigen::Vector3d p_S = X_SF * p;
      const Eigen::Vector2d at = *Project(view.sensor, p_S);
      const int u = static_cast<int>(at.x()), v = static_cast<int>(at.y());
      if (u + 1 >= view.sensor.columns || v + 1 >= view.sensor.rows) continue;
      const auto& image = view.exposure.image;
      const double a = image.at(u, v), b = image.at(u + 1, v), c = image.at(u, v + 1), d = image.at(u + 1, v + 1);
      const double fu = at.x() - u, fv = at.y() - v, gu = (b + d - a - c) / 2, gv = (c + d - a - b) / 2;
      const double steepness = std::sqrt(1 + std::pow(gu * view.sensor.focal_u, 2) + std::pow(gv * view.sensor.focal_v, 2));
      if (!std::isfinite(a + b + c + d) || steepness > 2.0) continue;
      const double z = (1 - fv) * ((1 - fu) * a + fu * b) + fv * ((1 - fu) * c + fu * d);
      off.push_back(std::abs(z - p_S.z()) / steepness);
    }
    ASSERT_GT(off.size(), grid.points.size() * 6 / 10);
    // What is far off lies on a sheet behind another, which parallel rays do not reach.
    std::sort(off.begin(), off.end());
    EXPECT_LT(off[off.size() / 2], 2e-5);
    EXPECT_LT(off[off.size() * 90 / 100], 6e-5);
    EXPECT_LT(off[off.size() * 97 / 100], 5e-4);
  }
}

}  // namespace
}  // namespace geond::calib
