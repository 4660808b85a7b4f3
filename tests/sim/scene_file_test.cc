// SPDX-License-Identifier: Apache-2.0
#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "sim/scene.h"
#include "sim/sim_config.h"

namespace geond::sim {
namespace {

using testing::AllOf;
using testing::HasSubstr;

class SceneFile : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::path(testing::TempDir()) /
              (std::string("scene_") + testing::UnitTest::GetInstance()->current_test_info()->name());
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  std::filesystem::path Write(const std::string& text, const std::string& name = "scene.toml") {
    std::ofstream(folder_ / name) << text;
    return folder_ / name;
  }
  std::string Failure(const std::string& text) {
    try {
      ReadScene(Write(text));
    } catch (const ConfigError& error) {
      return error.what();
    }
    return "no ConfigError";
  }
  std::filesystem::path folder_;
};

TEST_F(SceneFile, ReadsUnitsAndRestsTheObjectOnTheTable) {
  const Scene scene = ReadScene(Write(R"(
name = "two"
[[geon]]
type = "cuboid"
size_mm = [10, 20, 30]
position_mm = [1, 2, 500]
[[geon]]
type = "curved_cylinder"
size_mm = [5, 5, 40]
bend_per_mm = 0.02
position_mm = [0, 0, 540]
axis = [0, 0, 2]
angle_deg = 90
)"));
  ASSERT_EQ(scene.parts.size(), 2u);
  EXPECT_NEAR((scene.parts[0].geon.size - Eigen::Vector3d(0.01, 0.02, 0.03)).norm(), 0.0, 1e-15);
  EXPECT_NEAR((scene.parts[0].geon.X_TG.translation() - Eigen::Vector3d(0.001, 0.002, 0.03)).norm(), 0.0, 1e-4);
  EXPECT_DOUBLE_EQ(scene.parts[1].geon.bend, 20.0);
  EXPECT_NEAR((scene.parts[1].geon.X_TG.Rotate({1, 0, 0}) - Eigen::Vector3d(0, 1, 0)).norm(), 0.0, 1e-12);
}

TEST_F(SceneFile, EveryErrorNamesFileLineAndKey) {
  const std::string good = "[[geon]]\ntype = \"cuboid\"\nsize_mm = [1, 2, 3]\n";
  EXPECT_THAT(Failure(good + "colour = 3\n"),
              AllOf(HasSubstr("scene.toml"), HasSubstr("line 4"), HasSubstr("geon[1].colour")));
  EXPECT_THAT(Failure("[[geon]]\ntype = \"cube\"\nsize_mm = [1, 2, 3]\n"),
              AllOf(HasSubstr("line 2"), HasSubstr("geon[1].type"), HasSubstr("tapered_cuboid")));
  EXPECT_THAT(Failure("[[geon]]\ntype = \"cuboid\"\n"), AllOf(HasSubstr("geon[1].size_mm"), HasSubstr("missing")));
  EXPECT_THAT(Failure("[[geon]]\ntype = \"cuboid\"\nsize_mm = [1, 2]\n"),
              AllOf(HasSubstr("line 3"), HasSubstr("3 numbers")));
  EXPECT_THAT(Failure("[[geon]]\ntype = \"cuboid\"\nsize_mm = [1, -2, 3]\n"),
              AllOf(HasSubstr("line 3"), HasSubstr("-2")));
  EXPECT_THAT(Failure("[[geon]]\ntype = \"cuboid\"\nsize_mm = [1, nan, 3]\n"), HasSubstr("not a number"));
  EXPECT_THAT(Failure(good + "taper = [0.1, 0.1]\n"), AllOf(HasSubstr("geon[1].taper"), HasSubstr("tapered types")));
  EXPECT_THAT(Failure(good + "rpy_deg = [0, 0, 1]\naxis = [0, 0, 1]\nangle_deg = 3\n"), HasSubstr("geon[1].rpy_deg"));
  EXPECT_THAT(Failure("[[geon]]\ntype = \"curved_cuboid\"\nsize_mm = [10, 2, 30]\nbend_per_mm = 0.2\n"),
              HasSubstr("folds over"));
  EXPECT_THAT(Failure("name = \"empty\"\n"), HasSubstr("no object"));
  EXPECT_THAT(Failure("name = = 3\n"), AllOf(HasSubstr("scene.toml"), HasSubstr("line 1")));
  EXPECT_THROW(ReadScene(folder_ / "absent.toml"), FileError);
}

TEST_F(SceneFile, MeshesAreReadByPathAndScale) {
  std::ofstream(folder_ / "tetra.off")
      << "OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";
  const Scene scene = ReadScene(Write("[[mesh]]\nfile = \"tetra.off\"\nscale_mm = 50.0\nposition_mm = [0, 0, 7]\n"));
  ASSERT_EQ(scene.bodies.size(), 1u);
  EXPECT_NEAR(Volume(scene.bodies[0].mesh), std::pow(0.05, 3) / 6.0, 1e-12);
  const SceneGeometry geometry(scene);
  const auto hit = geometry.Cast({{0.01, 0.01, 0.5}, {0, 0, -1}}, Eigen::Vector3d::Zero());
  EXPECT_EQ(hit.item, 0);
  EXPECT_NEAR(0.5 - hit.t, 0.03, 1e-12);  // x + y + z = 50 mm
  EXPECT_NEAR(hit.cos_incidence, 1.0 / std::sqrt(3.0), 1e-12);
  EXPECT_THROW(ReadScene(Write("[[mesh]]\nfile = \"none.off\"\n")), FileError);
}

TEST(SampleScenes, StandOnTheTableAreOfHandySizeAndHoldTogether) {
  int scenes = 0;
  for (const auto& entry : std::filesystem::directory_iterator(GEOND_SOURCE_DIR "/config/scenes")) {
    const Scene scene = ReadScene(entry.path());
    SCOPED_TRACE(entry.path().string());
    ++scenes;
    const SceneGeometry geometry(scene);
    EXPECT_NEAR(geometry.box().min().z(), 0.0, 0.002);  // the box is that of the shells, a little larger
    EXPECT_GE(geometry.box().sizes().maxCoeff(), 0.080);
    EXPECT_LE(geometry.box().sizes().maxCoeff(), 0.202);
    // Every part runs into another one: some point of its surface is inside it.
    for (std::size_t i = 0; scene.parts.size() > 1 && i < scene.parts.size(); ++i) {
      const GeonSurface surface(scene.parts[i].geon);
      bool meets = false;
      for (std::size_t j = 0; j < scene.parts.size(); ++j) {
        if (j == i) continue;
        const GeonSurface other(scene.parts[j].geon);
        for (int k = 0; k < 300; ++k) {
          const double z = 1.0 - (2.0 * k + 1.0) / 300.0, angle = 2.399963 * k, r = std::sqrt(1.0 - z * z);
          const Eigen::Vector3d direction(r * std::cos(angle), r * std::sin(angle), z);
          meets = meets || other.At(surface.PointAlong(direction)).value < 1.0 ||
                  surface.At(other.PointAlong(direction)).value < 1.0;
        }
      }
      EXPECT_TRUE(meets) << scene.parts[i].name;
    }
  }
  EXPECT_GE(scenes, 13);
}

TEST(SimConfigFile, TheShippedFileSaysTheDefaults) {
  const SimConfig shipped = ReadSimConfig(GEOND_SOURCE_DIR "/config/sim.toml");
  const SimConfig defaults = ReadSimConfig({});
  EXPECT_EQ(shipped.station.assumed.sensor, defaults.station.assumed.sensor);
  EXPECT_EQ(shipped.station.axis_error.tilt, defaults.station.axis_error.tilt);
  EXPECT_EQ(shipped.station.turntable.backlash, defaults.station.turntable.backlash);
  EXPECT_EQ(shipped.station.camera.dropout_end, defaults.station.camera.dropout_end);
  EXPECT_EQ(shipped.station.exposure_time, defaults.station.exposure_time);
  EXPECT_EQ(shipped.faults, defaults.faults);
  EXPECT_EQ(OpenSimStation(shipped)->scene().name, "bowling pin");
}

TEST_F(SceneFile, SimConfigErrorsNameTheKey) {
  const auto failure = [&](const std::string& text) -> std::string {
    try {
      ReadSimConfig(Write(text, "sim.toml"));
    } catch (const ConfigError& error) {
      return error.what();
    }
    return "no ConfigError";
  };
  EXPECT_THAT(failure("[rangefinder]\ndistance_mm = 1\n"),
              AllOf(HasSubstr("sim.toml"), HasSubstr("line 2"), HasSubstr("rangefinder.distance_mm")));
  EXPECT_THAT(failure("[turntable]\nspeed = 1\n"), HasSubstr("turntable.speed"));
  EXPECT_THAT(failure("[faults]\nlines = \"broken\"\n"), AllOf(HasSubstr("faults.lines"), HasSubstr("intermittent")));
  EXPECT_THAT(failure("seed = 1.5\n"), HasSubstr("whole number"));
}

}  // namespace
}  // namespace geond::sim
