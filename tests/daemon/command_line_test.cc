// SPDX-License-Identifier: Apache-2.0
#include "daemon/command/command_line.h"

#include <fstream>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/geometry/mesh_files.h"
#include "core/geon/geon.h"
#include "daemon/command/command.h"
#include "daemon/command/progress_bar.h"
#include "tests/daemon/small_station.h"

namespace geond::daemon {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

struct Outcome {
  int code;
  std::string out, err;
  Json json() const { return Json::parse(out); }
};

Outcome Geon(const std::vector<std::string>& arguments, std::stop_token stop = {}) {
  std::ostringstream out, err;
  const int code = RunGeon(arguments, stop, {out, err});
  return {code, out.str(), err.str()};
}

// Files of an egg of 20 x 20 x 30 mm, in millimetres.
class CommandLineTest : public testing::Test {
 protected:
  CommandLineTest() {
    Geon_ egg;
    egg.type = GeonType::kEllipsoid;
    egg.size = {20, 20, 30};
    WriteMesh(GeonMesh(egg, 6.0), mesh_);
    WriteCloud(SampleGeon(egg, 600), cloud_);
    std::ofstream contour(contour_);
    contour << "# a square\n";
    for (int i = 0; i < 10; ++i) contour << i << " 0\n";
    for (int i = 0; i < 10; ++i) contour << "10, " << i << "\n";
    for (int i = 0; i < 10; ++i) contour << 10 - i << "\t10\n";
    for (int i = 0; i < 10; ++i) contour << "0 " << 10 - i << "\n";
  }
  using Geon_ = geond::Geon;

  std::string Path(const std::string& name) const { return (folder_.path() / name).string(); }

  TemporaryFolder folder_;
  const std::string mesh_ = Path("egg.off"), cloud_ = Path("egg.ply"), contour_ = Path("square.txt");
};

void ExpectKeys(const Json& json, const std::vector<std::string>& keys) {
  for (const std::string& key : keys) EXPECT_TRUE(json.contains(key)) << key << " in " << json.dump().substr(0, 300);
}

TEST_F(CommandLineTest, DescribeAnswersItsKeys) {
  const Outcome outcome = Geon({"describe", mesh_, "--json", "--triangles", "400"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.err, IsEmpty());
  const Json json = outcome.json();
  ExpectKeys(json, {"parts", "relations", "n_parts", "seconds", "version"});
  ASSERT_EQ(json["n_parts"], 1);
  const Json& part = json["parts"][0];
  ExpectKeys(part, {"id", "type", "type_index", "pose", "size_mm", "taper", "bend_per_mm", "residual_mm", "t1_mm", "t2",
                    "margin", "confidence", "points", "all_models"});
  ExpectKeys(part["pose"], {"position_mm", "quaternion"});
  ExpectKeys(part["pose"]["quaternion"], {"w", "x", "y", "z"});
  ExpectKeys(part["all_models"][0], {"type", "residual_mm"});
  EXPECT_EQ(part["all_models"].size(), 7u);
  EXPECT_EQ(part["type"], "ellipsoid");
  EXPECT_EQ(part["type_index"], 1);
  std::vector<double> size = part["size_mm"];
  std::sort(size.begin(), size.end());
  EXPECT_NEAR(size[0], 20, 0.6);
  EXPECT_NEAR(size[2], 30, 0.9);
}

TEST_F(CommandLineTest, MeshAnswersItsKeys) {
  const std::string output = Path("out.ply");
  const Outcome outcome = Geon({"mesh", mesh_, "-o", output, "--triangles", "600", "--json"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const Json json = outcome.json();
  ExpectKeys(json, {"n_vertices", "n_triangles", "closed", "manifold", "genus", "volume_mm3", "min_angle_deg", "seconds"});
  EXPECT_EQ(json["closed"], true);
  EXPECT_EQ(json["manifold"], true);
  EXPECT_EQ(json["genus"], 0);
  EXPECT_NEAR(json["volume_mm3"].get<double>(), 4.0 / 3.0 * M_PI * 20 * 20 * 30, 2500);
  EXPECT_EQ(ReadGeometry(output).mesh.triangles.size(), json["n_triangles"]);
}

TEST_F(CommandLineTest, UnitsScaleWhatComesOut) {
  const double in_mm = Geon({"charge", mesh_, "--json"}).json()["capacitance_mm"];
  const double in_inches = Geon({"charge", mesh_, "--json", "--unit", "in"}).json()["capacitance_mm"];
  EXPECT_NEAR(in_inches / in_mm, 25.4, 1e-6);
  EXPECT_NEAR(in_mm, 23.1, 0.5);  // prolate spheroid: sqrt(c^2 - a^2) / arcosh(c / a)
}

TEST_F(CommandLineTest, WhatIsOddInAFileIsSaid) {
  const std::string file = Path("tetrahedron.off");  // in metres, and its last face names a corner twice
  std::ofstream(file) << "OFF\n4 5 0\n0 0 0\n.1 0 0\n0 .1 0\n0 0 .1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 0 3 2\n3 0 0 1\n";
  const Outcome taken_for_mm = Geon({"charge", file});
  EXPECT_THAT(taken_for_mm.out, testing::AllOf(HasSubstr("a face without area"), HasSubstr("--unit")));
  const Json notes = Geon({"charge", file, "--json", "--unit", "m"}).json()["notes"];
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_THAT(notes[0].get<std::string>(), HasSubstr("twice"));
  EXPECT_THAT(Geon({"describe", file}).out, HasSubstr("--unit"));
}

TEST_F(CommandLineTest, ChargeAnswersItsKeys) {
  const std::string output = Path("charge.ply");
  const Outcome outcome = Geon({"charge", mesh_, "--json", "--solver", "dense", "-o", output});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const Json json = outcome.json();
  ExpectKeys(json, {"n_triangles", "capacitance_mm", "potential_spread", "iterations", "residual", "solver", "seconds",
                    "peak_memory_mb", "density"});
  ExpectKeys(json["seconds"], {"setup", "solve"});
  EXPECT_EQ(json["solver"], "dense");
  ASSERT_EQ(json["density"].size(), json["n_triangles"]);
  const TriangleMesh mesh = ReadGeometry(mesh_).mesh;
  const std::vector<double> areas = TriangleAreas(mesh);
  double charge = 0.0;
  for (std::size_t i = 0; i < areas.size(); ++i) charge += areas[i] * json["density"][i].get<double>();
  EXPECT_NEAR(charge, 1.0, 1e-9);
}

TEST_F(CommandLineTest, ContourAnswersItsKeys) {
  const Json json = Geon({"contour", contour_, "--json"}).json();
  ExpectKeys(json, {"density", "n"});
  EXPECT_EQ(json["n"], 40);
  ASSERT_EQ(json["density"].size(), 40u);
  EXPECT_GT(json["density"][0].get<double>(), 2.0 * json["density"][5].get<double>()) << "charge gathers at corners";
}

TEST_F(CommandLineTest, SegmentAnswersItsKeys) {
  const std::string seg = Path("out.seg");
  const Outcome outcome = Geon({"segment", mesh_, "--json", "--seg", seg});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const Json json = outcome.json();
  ExpectKeys(json, {"n_parts", "labels", "boundaries"});
  EXPECT_EQ(json["n_parts"], 1);
  std::ifstream file(seg);
  std::vector<int> labels;
  for (int label; file >> label;) labels.push_back(label);
  EXPECT_EQ(labels, json["labels"].get<std::vector<int>>());
}

TEST_F(CommandLineTest, FitAnswersItsKeys) {
  const Outcome outcome = Geon({"fit", cloud_, "--json"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const Json json = outcome.json();
  ExpectKeys(json, {"best", "fits"});
  EXPECT_EQ(json["best"], "ellipsoid");
  ASSERT_EQ(json["fits"].size(), 7u);
  ExpectKeys(json["fits"][0], {"type", "type_index", "residual_mm", "t1_mm", "t2", "pose", "size_mm", "taper", "bend_per_mm",
                               "evaluations", "seconds"});
  const Json one = Geon({"fit", cloud_, "--json", "--model", "cuboid"}).json();
  EXPECT_EQ(one["fits"].size(), 1u);
  EXPECT_EQ(one["best"], "cuboid");
}

TEST_F(CommandLineTest, AScanIsSimulatedRegisteredMergedAndDrawn) {
  const std::string scene = Path("scene.toml"), scan = Path("scan"), refined = Path("refined"), cloud = Path("merged.ply");
  std::ofstream(scene) << "name = \"egg\"\n[[geon]]\nname = \"egg\"\ntype = \"ellipsoid\"\nsize_mm = [30, 30, 40]\n"
                          "position_mm = [0, 0, 40]\n";
  const Outcome simulated = Geon({"simulate", scene, "-o", scan, "--views", "4", "--columns", "64", "--rows", "64", "--json"});
  ASSERT_EQ(simulated.code, 0) << simulated.err;
  ExpectKeys(simulated.json(), {"n_views", "truth"});
  EXPECT_EQ(simulated.json()["n_views"], 4);

  const Outcome registered = Geon({"register", scan, "-o", refined, "--json"});
  ASSERT_EQ(registered.code, 0) << registered.err;
  ExpectKeys(registered.json(), {"views", "rms_mm", "iterations", "seconds"});
  ExpectKeys(registered.json()["views"][0]["X_TS"], {"position_mm", "quaternion"});

  const Outcome merged = Geon({"merge", refined, "-o", cloud, "--json"});
  ASSERT_EQ(merged.code, 0) << merged.err;
  ExpectKeys(merged.json(), {"n_points_in", "n_points_out", "seconds"});
  EXPECT_EQ(ReadGeometry(cloud).cloud.size(), merged.json()["n_points_out"]);
  EXPECT_LE(merged.json()["n_points_out"], merged.json()["n_points_in"]);

  const std::string picture = Path("picture.png");
  const Outcome view = Geon({"view", refined, "-o", picture, "--width", "320", "--height", "240", "--triangles", "300", "--json"});
  ASSERT_EQ(view.code, 0) << view.err;
  std::ifstream file(picture, std::ios::binary);
  std::string head(8, '\0');
  file.read(head.data(), 8);
  EXPECT_EQ(head, "\x89PNG\r\n\x1a\n");
}

TEST_F(CommandLineTest, AnExperimentIsReproduced) {
  const Outcome outcome = Geon({"reproduce", "figure_6_4", "--quick", "-o", Path("reproduced"), "--json"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  ExpectKeys(outcome.json(), {"version", "quick", "bars", "bars_met", "experiments"});
  ExpectKeys(outcome.json()["experiments"][0]["figures"][0], {"key", "thesis", "repaired", "today", "bar", "bar_met"});
  EXPECT_TRUE(std::filesystem::exists(folder_.path() / "reproduced" / "report.html"));
  EXPECT_TRUE(std::filesystem::exists(folder_.path() / "reproduced" / "figures.json"));
  EXPECT_EQ(Geon({"reproduce", "figure_99"}).code, 2);
}

TEST_F(CommandLineTest, WrongLinesAreTwoAndFailedWorkIsOne) {
  for (const std::vector<std::string>& wrong : std::vector<std::vector<std::string>>{
           {}, {"descibe", mesh_}, {"describe"}, {"describe", mesh_, "--unit", "furlong"}, {"charge", mesh_, "--solver", "slow"},
           {"mesh", mesh_}, {"fit", cloud_, "--model", "teapot"}, {"describe", mesh_, "--triangles", "many"},
           {"view", mesh_, "-o", "x.png", "--show", "nothing"}}) {
    const Outcome outcome = Geon(wrong);
    EXPECT_EQ(outcome.code, 2) << outcome.err;
    EXPECT_THAT(outcome.out, IsEmpty());
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  }
  std::ofstream(Path("broken.ply")) << "ply\nformat ascii 1.0\nelement vertex 3\n";
  std::ofstream(Path("wrong.txt")) << "1 2\n3\n";
  for (const std::vector<std::string>& failing : std::vector<std::vector<std::string>>{
           {"describe", Path("absent.ply")}, {"describe", Path("broken.ply")}, {"charge", cloud_}, {"describe", folder_.path()},
           {"contour", Path("wrong.txt")}, {"register", mesh_}, {"describe", Path("picture.png")}}) {
    for (const bool json : {false, true}) {
      std::vector<std::string> arguments = failing;
      if (json) arguments.push_back("--json");
      const Outcome outcome = Geon(arguments);
      EXPECT_EQ(outcome.code, 1) << outcome.err;
      EXPECT_THAT(outcome.out, IsEmpty());
      EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
    }
  }
  EXPECT_THAT(Geon({"contour", Path("wrong.txt")}).err, HasSubstr("line 2"));
}

TEST_F(CommandLineTest, StoppedWorkSaysCancelled) {
  std::stop_source stop;
  stop.request_stop();
  const Outcome outcome = Geon({"describe", mesh_, "--json"}, stop.get_token());
  EXPECT_EQ(outcome.code, 1);
  EXPECT_EQ(outcome.err, "geon: cancelled\n");
  EXPECT_THAT(outcome.out, IsEmpty());
}

TEST_F(CommandLineTest, HelpIsForEveryCommand) {
  const Outcome help = Geon({"--help"});
  EXPECT_EQ(help.code, 0);
  for (const char* command : {"describe", "mesh", "charge", "contour", "segment", "fit", "register", "merge", "simulate", "view", "reproduce",
                              "scan", "status", "watch", "cancel", "stop", "home", "reset", "scans", "objects", "api", "doctor"}) {
    EXPECT_THAT(help.out, HasSubstr(command));
    EXPECT_EQ(Geon({command, "--help"}).code, 0) << command;
  }
  EXPECT_EQ(Geon({"--version"}).code, 0);
}

TEST(ProgressBar, DrawsOnlyWhereItMay) {
  std::ostringstream on, off;
  {
    ProgressBar bar(on, true), none(off, false);
    bar.Show("fit", 0, 4);
    bar.Show("fit", 4, 4);
    none.Show("fit", 1, 4);
  }
  EXPECT_THAT(on.str(), HasSubstr("0/4"));
  EXPECT_THAT(on.str(), HasSubstr("[##############################] 4/4"));
  EXPECT_THAT(off.str(), IsEmpty());
}

TEST(Units, AreThoseOfTheCommandLine) {
  EXPECT_EQ(MetersPerUnit("mm"), 0.001);
  EXPECT_EQ(MetersPerUnit("in"), 0.0254);
  EXPECT_THROW(MetersPerUnit("ell"), std::invalid_argument);
}

}  // namespace
}  // namespace geond::daemon
