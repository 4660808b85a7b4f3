// SPDX-License-Identifier: Apache-2.0
#include "calib/register_views.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "calib/make_view.h"
#include "calib/pair_terms.h"
#include "calib/pose_model.h"
#include "tests/calib/registration_case.h"
#include "tests/calib/synthetic_scan.h"

namespace geond::calib {
namespace {

using Model = RegisterOptions::Model;

struct Start {
  std::vector<RangeView> views;
  std::vector<Pose> truth;
};

Start SyntheticStart(const SyntheticScene& scene, int n, double noise) {
  Start start;
  start.views = MakeViews(SyntheticScan(scene, n, noise));
  for (const auto& view : start.views) start.truth.push_back(view.X_TS);
  return start;
}

Eigen::Vector3d Middle() { return {0.0, 0.0, 0.03}; }

// Each view turned and shifted about the object's middle by normal deviates.
std::vector<Pose> Perturbed(const std::vector<Pose>& poses, double rotation, double translation, std::uint64_t seed) {
  Noise random(seed);
  std::vector<Pose> moved;
  for (const auto& X : poses) {
    Vector6d motion;
    motion << rotation * random.Vector(), translation * random.Vector();
    moved.push_back(Moved(X, motion, Middle(), 1.0));
  }
  return moved;
}

TEST(PoseModel, MotionsGoThereAndBack) {
  const Pose X(Eigen::Quaterniond(0.9, 0.1, -0.3, 0.2), {0.4, -0.1, 0.2});
  Vector6d motion;
  motion << 0.02, -0.01, 0.03, 0.004, 0.005, -0.006;
  EXPECT_LT((MotionBetween(X, Moved(X, motion, Middle(), 0.05), Middle(), 0.05) - motion).norm(), 1e-14);
}

TEST(PoseModel, JacobianIsTheDifferenceQuotient) {
  const auto station = SyntheticStation();
  std::vector<Pose> poses;
  std::vector<double> angles;
  for (int k = 0; k < 3; ++k) angles.push_back(2.0 * k), poses.push_back(SensorInTurntable(station, angles.back()));
  const double length = 0.04, h = 1e-6;
  for (PoseModel model : {PoseModel::Free(poses, Middle(), length, {}),
                          PoseModel::Turntable(poses, angles, Middle(), length, {})}) {
    Eigen::VectorXd at(model.parameters().size());
    for (Eigen::Index k = 0; k < at.size(); ++k) at[k] = 0.003 * std::sin(1.0 + 2.0 * static_cast<double>(k));
    model.Set(at);
    const Eigen::MatrixXd J = model.Jacobian();
    const auto here = model.X_TS();
    for (Eigen::Index k = 0; k < at.size(); ++k) {
      Eigen::VectorXd plus = at, minus = at;
      plus[k] += h, minus[k] -= h;
      model.Set(plus);
      const auto X_plus = model.X_TS();
      model.Set(minus);
      const auto X_minus = model.X_TS();
      for (int v = 0; v < 3; ++v) {
        const Vector6d quotient = (MotionBetween(here[v], X_plus[v], Middle(), length) -
                                   MotionBetween(here[v], X_minus[v], Middle(), length)) / (2.0 * h);
        EXPECT_LT((J.block<6, 1>(6 * v, k) - quotient).norm(), 1e-6) << "parameter " << k << " view " << v;
      }
    }
  }
}

TEST(ComparePair, ACommonMotionCostsNothing) {
  const Start start = SyntheticStart(BoxAndSphere(), 8, 0.0002);
  std::vector<ViewPoints> ready;
  for (const auto& view : start.views) ready.push_back(ReadyForRegistration(view));
  Vector6d d;
  d << 0.1, -0.2, 0.05, 0.01, 0.02, -0.03;
  auto moved = start.truth;
  for (auto& X : moved) X = Moved(X, d, Middle(), 1.0);
  const PairTerm before = ComparePair(ready, start.truth, 0, 1, Middle(), 0.04, {});
  const PairTerm after = ComparePair(ready, moved, 0, 1, Middle(), 0.04, {});
  EXPECT_EQ(before.points, after.points);
  EXPECT_NEAR(before.squares, after.squares, 1e-9 * before.squares);
}

TEST(RegisterViews, ExactPosesStay) {
  const Start start = SyntheticStart(BoxAndSphere(), 6, 0.0);
  for (const Model model : {Model::kTurntable, Model::kFree, Model::kAuto}) {
    RegisterOptions options;
    options.model = model;
    const auto result = RegisterViews(start.views, options);
    const auto error = ComparePoses(start.views, result.X_TS, start.truth);
    EXPECT_LT(error.displacement_rms, 1.5e-5) << static_cast<int>(model);
  }
}

TEST(RegisterViews, FindsTheAxisAgain) {
  const Start start = SyntheticStart(BoxAndSphere(), 8, 0.0002);
  Vector6d off;  // the sensor stands elsewhere against the axis than the calibration says
  off << 0.006, -0.005, 0.0, 0.0006, -0.0005, 0.0;
  std::vector<Pose> wrong;
  for (const auto& view : start.views) {
    const Pose turn = Pose::Rotation(Eigen::Vector3d::UnitZ(), view.table_angle);
    wrong.push_back(Inverse(turn) * Moved(turn * view.X_TS, off, Middle(), 1.0));
  }
  const auto views = StartingAt(start.views, wrong);
  const auto result = RegisterViews(views);
  EXPECT_EQ(result.model, Model::kTurntable);
  EXPECT_TRUE(result.summary.converged) << result.summary.message;
  EXPECT_LT(result.rms_after, 0.6 * result.rms_before);
  const auto before = ComparePoses(views, wrong, start.truth), after = ComparePoses(views, result.X_TS, start.truth);
  EXPECT_GT(before.displacement_rms, 2e-4);
  EXPECT_LT(after.displacement_rms, 5e-5);
  EXPECT_LT(after.normal_rms, 3e-5);
  EXPECT_NEAR(result.sensor_correction[0], -off[0], 8e-4);
  EXPECT_NEAR(result.sensor_correction[1], -off[1], 8e-4);
}

TEST(RegisterViews, FindsTheAxisOfAnObjectThatStandsFarFromIt) {
  SyntheticScene scene = BoxAndSphere();
  const Eigen::Vector3d beside(0.045, -0.020, 0.0);
  for (auto& box : scene.boxes) box.low += beside, box.high += beside;
  for (auto& sphere : scene.spheres) sphere.center += beside;
  const Start start = SyntheticStart(scene, 8, 0.0002);
  Vector6d off;
  off << 0.006, -0.005, 0.0, 0.0006, -0.0005, 0.0;
  std::vector<Pose> wrong;
  for (const auto& view : start.views) {
    const Pose turn = Pose::Rotation(Eigen::Vector3d::UnitZ(), view.table_angle + 0.002 * std::sin(3.0 * view.table_angle));
    wrong.push_back(Inverse(turn) * Moved(turn * view.X_TS, off, Middle(), 1.0));
  }
  RegisterOptions options;
  options.model = Model::kTurntable;
  const auto result = RegisterViews(StartingAt(start.views, wrong), options);
  EXPECT_TRUE(result.summary.converged) << result.summary.message;
  EXPECT_LT(ComparePoses(start.views, result.X_TS, start.truth).displacement_rms, 5e-5);
}

TEST(RegisterViews, MovesEachViewWhereTheTableDidNotTurnAsItSaid) {
  Start start = SyntheticStart(BoxAndSphere(), 8, 0.0002);
  // The object was lifted and put back a little elsewhere between views: no axis explains that.
  const auto moved = Perturbed(start.truth, 0.01, 0.001, 7);
  const auto views = StartingAt(start.views, moved);
  for (const Model model : {Model::kFree}) {
    RegisterOptions options;
    options.model = model;
    const auto result = RegisterViews(views, options);
    EXPECT_EQ(result.model, Model::kFree);
    const auto error = ComparePoses(views, result.X_TS, start.truth);
    EXPECT_LT(error.displacement_rms, 8e-5);
  }
}

TEST(RegisterViews, ChoosesFreePosesOnEvidenceOnly) {
  // True poses off the axis: the images were taken from elsewhere than the angles say.
  RecordedScan scan = SyntheticScan(BoxAndSphere(), 1, 0.0);
  const SyntheticScene scene = BoxAndSphere();
  const auto station = SyntheticStation();
  Noise random(11);
  RecordedScan shaken;
  shaken.station = station;
  std::vector<Pose> truth;
  for (int k = 0; k < 8; ++k) {
    RecordedScan::View view;
    view.exposure.table_angle = M_PI / 4 * k;
    view.sensor = station.sensor;
    view.X_TS_measured = SensorInTurntable(station, view.exposure.table_angle);
    Vector6d motion;
    motion << 0.004 * random.Vector(), 0.0006 * random.Vector();
    truth.push_back(Moved(view.X_TS_measured, motion, Middle(), 1.0));
    view.exposure.image = TakeImage(scene, view.sensor, truth.back(), 0.0002, random);
    shaken.views.push_back(std::move(view));
  }
  const auto views = MakeViews(shaken);
  const auto result = RegisterViews(views);
  EXPECT_EQ(result.model, Model::kFree);
  EXPECT_LT(ComparePoses(views, result.X_TS, truth).displacement_rms, 1e-4);

  const auto still = MakeViews(SyntheticScan(scene, 8, 0.0002, 3));
  EXPECT_EQ(RegisterViews(still).model, Model::kTurntable);
}

TEST(RegisterViews, LeavesTheRotationsOfASphereAsMeasuredAndSaysSo) {
  SyntheticScene scene;
  scene.spheres.push_back({{0.004, -0.003, 0.035}, 0.03});
  const Start start = SyntheticStart(scene, 6, 0.0002);
  const auto moved = Perturbed(start.truth, 0.0, 0.0008, 13);
  RegisterOptions options;
  options.model = Model::kFree;
  const auto result = RegisterViews(StartingAt(start.views, moved), options);
  for (std::size_t k = 0; k < moved.size(); ++k) {
    const auto change = MotionBetween(moved[k], result.X_TS[k], scene.spheres[0].center, 1.0);
    EXPECT_LT(change.head<3>().norm(), 0.008) << k;  // priors share a shift between shift and turn; freely it would wander
  }
  EXPECT_LT(ComparePoses(start.views, result.X_TS, start.truth).normal_rms, 3e-5);
  ASSERT_FALSE(result.notes.empty());
  EXPECT_NE(result.notes[0].find("sphere"), std::string::npos) << result.notes[0];
}

TEST(RegisterViews, NamesTheTurnThatACylinderHides) {
  SyntheticScene scene;
  scene.cylinders.push_back({{0.0, 0.0}, 0.025, 0.0, 0.06});
  const Start start = SyntheticStart(scene, 6, 0.0002);
  const auto result = RegisterViews(start.views);
  const auto named = std::count_if(result.notes.begin(), result.notes.end(), [](const std::string& note) {
    return note.find("no turn about the table's axis") != std::string::npos;
  });
  EXPECT_EQ(named, 1) << testing::PrintToString(result.notes);
  EXPECT_LT(ComparePoses(start.views, result.X_TS, start.truth).displacement_rms, 4e-5);
}

// Two boxes, one on the other, sides along the axes.
SyntheticScene Steps() {
  SyntheticScene scene;
  scene.boxes = {{{-0.035, -0.025, 0.0}, {0.030, 0.025, 0.030}}, {{-0.010, -0.015, 0.030}, {0.025, 0.020, 0.060}}};
  return scene;
}

// Each of four views has one side for itself and the tops in common; with eight every side is seen by three.
TEST(RegisterViews, SaysWhatOnlyEdgesShow) {
  for (const int n : {4, 8}) {
    Start start = SyntheticStart(Steps(), n, 0.0002);
    RegisterOptions options;
    options.model = Model::kTurntable;
    const auto result = RegisterViews(StartingAt(start.views, Perturbed(start.truth, 0.006, 0.0005, 3)), options);
    const auto said = std::ranges::count_if(result.notes, [](const auto& note) { return note.starts_with("only edges"); });
    EXPECT_EQ(said, n == 4 ? 2 : 0) << n;
  }
}

// A view that faces a side shows no shift along it but by its edges, where normals are part of both faces.
TEST(RegisterViews, FreePosesDoNotFollowEdges) {
  Start start = SyntheticStart(Steps(), 8, 0.0002);
  RegisterOptions options;
  options.model = Model::kFree;
  const auto views = StartingAt(start.views, Perturbed(start.truth, 0.006, 0.0005, 5));
  EXPECT_LT(ComparePoses(views, RegisterViews(views, options).X_TS, start.truth).normal_rms, 2.5e-5);
}

TEST(RegisterViews, NeedsNoResidualsOfTheNormals) {
  Start start = SyntheticStart(Steps(), 8, 0.0002);
  for (auto& view : start.views) view.normal_residuals.clear();
  const auto views = StartingAt(start.views, Perturbed(start.truth, 0.006, 0.0005, 3));
  RegisterOptions options;
  options.model = Model::kTurntable;
  EXPECT_LT(ComparePoses(views, RegisterViews(views, options).X_TS, start.truth).normal_rms, 2e-5);
}

TEST(RegisterViews, SaysWhichViewsDoNotOverlap) {
  Start start = SyntheticStart(BoxAndSphere(), 4, 0.0002);
  for (auto& what : start.views[2].classes) what = PixelClass::kNothing;
  const auto result = RegisterViews(start.views);
  const auto said = std::count_if(result.notes.begin(), result.notes.end(),
                                  [](const std::string& note) { return note.find("view 2") != std::string::npos; });
  EXPECT_EQ(said, 1);
}

TEST(RegisterViews, IsTheSameToTheBitForAnyNumberOfThreads) {
  const Start start = SyntheticStart(BoxAndSphere(), 5, 0.0002);
  const auto views = StartingAt(start.views, Perturbed(start.truth, 0.005, 0.0005, 17));
  RegisterOptions one, three;
  one.threads = 1;
  three.threads = 3;
  const auto a = RegisterViews(views, one), b = RegisterViews(views, three);
  for (std::size_t k = 0; k < a.X_TS.size(); ++k) {
    EXPECT_EQ(a.X_TS[k].rotation().coeffs(), b.X_TS[k].rotation().coeffs());
    EXPECT_EQ(a.X_TS[k].translation(), b.X_TS[k].translation());
  }
}

TEST(RegisterViews, EndsWhenAskedTo) {
  const Start start = SyntheticStart(BoxAndSphere(), 3, 0.0002);
  std::stop_source stop;
  stop.request_stop();
  EXPECT_THROW(RegisterViews(start.views, {}, stop.get_token()), Cancelled);
}

TEST(RegisterViews, KeepsWhatItGetsWithFewerThanTwoViews) {
  EXPECT_TRUE(RegisterViews({}).X_TS.empty());
  const Start start = SyntheticStart(BoxAndSphere(), 1, 0.0);
  const auto result = RegisterViews(start.views);
  EXPECT_EQ(result.X_TS[0].translation(), start.truth[0].translation());
}

TEST(RegisterViews, RecordedBoxWithCylinderComesWithinTheBar) {
  const RegistrationCase data = ReadRegistrationCase(std::filesystem::path(GEOND_TEST_DATA) / "registration/boxcyl_v8");
  RegisterOptions options;
  const auto by_axis = RegisterViews(StartingAt(data.views, data.X_TS_perturbed), options);
  EXPECT_EQ(by_axis.model, Model::kTurntable);
  EXPECT_LT(ComparePoses(data.views, by_axis.X_TS, data.X_TS_true).normal_rms, 0.012e-3);
  options.model = Model::kFree;
  const auto free = RegisterViews(StartingAt(data.views, data.X_TS_perturbed), options);
  EXPECT_LT(ComparePoses(data.views, free.X_TS, data.X_TS_true).displacement_rms, 0.03e-3);
}

}  // namespace
}  // namespace geond::calib
