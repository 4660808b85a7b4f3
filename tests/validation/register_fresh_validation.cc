// SPDX-License-Identifier: Apache-2.0
// Joint registration on fresh scans of simple solids with known poses: errors by number of views and start, and the share of
// random starts that come home. register_fresh_validation [starts]
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <string>

#include "calib/make_view.h"
#include "calib/pair_terms.h"
#include "calib/pose_model.h"
#include "calib/register_views.h"
#include "tests/calib/registration_case.h"
#include "tests/calib/synthetic_scan.h"

using namespace geond;
using namespace geond::calib;

namespace {

struct Named {
  const char* name;
  SyntheticScene scene;
};

std::vector<Named> Scenes() {
  SyntheticScene steps, snowman, pair;
  steps.boxes = {{{-0.035, -0.025, 0.0}, {0.030, 0.025, 0.030}}, {{-0.010, -0.015, 0.030}, {0.025, 0.020, 0.060}}};
  snowman.spheres = {{{0.0, 0.0, 0.028}, 0.030}, {{0.004, 0.002, 0.070}, 0.021}};
  snowman.boxes = {{{0.010, -0.004, 0.062}, {0.042, 0.006, 0.072}}};
  pair.cylinders = {{{-0.020, 0.0}, 0.016, 0.0, 0.065}, {{0.022, 0.008}, 0.022, 0.0, 0.035}};
  return {{"box+sphere", BoxAndSphere()}, {"steps", steps}, {"snowman", snowman}, {"cylinders", pair}};
}

// Poses as a station with its axis off by 0.3 degree and 0.5 mm has them, each view off by more.
std::vector<Pose> StartPoses(const std::vector<RangeView>& views, double rotation, double translation, Noise& random) {
  const Eigen::Vector3d center(0, 0, 0.03);
  Vector6d off = Vector6d::Zero();
  const double a = 2.0 * M_PI * random.Uniform(), b = 2.0 * M_PI * random.Uniform();
  off << 0.0052 * std::cos(a), 0.0052 * std::sin(a), 0.0, 0.0005 * std::cos(b), 0.0005 * std::sin(b), 0.0;
  std::vector<Pose> poses;
  for (const auto& view : views) {
    const Pose turn = Pose::Rotation(Eigen::Vector3d::UnitZ(), view.table_angle);
    const Pose X = Inverse(turn) * Moved(turn * view.X_TS, off, center, 1.0);
    Vector6d motion;
    motion << rotation * random.Vector().normalized(), translation * random.Vector().normalized();
    poses.push_back(Moved(X, motion, center, 1.0));
  }
  return poses;
}

std::vector<Pose> PosesOf(const std::vector<RangeView>& views) {
  std::vector<Pose> poses;
  for (const auto& view : views) poses.push_back(view.X_TS);
  return poses;
}

}  // namespace

int main(int argc, char** argv) {
  const int starts = argc > 1 ? std::atoi(argv[1]) : 200;
  std::printf("%-11s %5s %7s | %32s | %32s | %6s %6s\n", "scene", "views", "points", "axis: displ, normal, shape mm",
              "free: displ, normal, shape mm", "cpu ax", "cpu fr");
  for (const auto& [name, scene] : Scenes()) {
    for (const int n : {4, 8, 12, 36}) {
      const auto made = MakeViews(SyntheticScan(scene, n, 0.0002, 100 + static_cast<std::uint64_t>(n),
                                                SyntheticStation(160, 0.17)));
      const auto truth = PosesOf(made);
      Noise random(7);
      const auto views = StartingAt(made, StartPoses(made, 0.01745, 0.001, random));
      PoseSetError error[2];
      double seconds[2];
      for (const int free : {0, 1}) {
        RegisterOptions options;
        options.model = free ? RegisterOptions::Model::kFree : RegisterOptions::Model::kTurntable;
        const std::clock_t clock = std::clock();
        const auto result = RegisterViews(views, options);
        seconds[free] = static_cast<double>(std::clock() - clock) / CLOCKS_PER_SEC;
        error[free] = ComparePoses(views, result.X_TS, truth);
      }
      std::printf("%-11s %5d %7zu | %10.4f %10.4f %10.4f | %10.4f %10.4f %10.4f | %6.2f %6.2f\n", name, n, ViewCloud(views[0]).size(),
                  error[0].displacement_rms * 1e3, error[0].normal_rms * 1e3, error[0].shape_rms * 1e3,
                  error[1].displacement_rms * 1e3, error[1].normal_rms * 1e3, error[1].shape_rms * 1e3, seconds[0], seconds[1]);
      std::fflush(stdout);
    }
  }
  std::printf("\n%d random starts of 5 degrees and 5 mm a view, 8 views: share within 0.1 mm rms displacement\n", starts);
  for (const auto& [name, scene] : Scenes()) {
    const auto made = MakeViews(SyntheticScan(scene, 8, 0.0002, 5, SyntheticStation(100, 0.17)));
    const auto truth = PosesOf(made);
    int home[2] = {0, 0};
    Noise random(21);
    for (int k = 0; k < starts; ++k) {
      const auto views = StartingAt(made, StartPoses(made, 0.0873, 0.005, random));
      for (const int free : {0, 1}) {
        RegisterOptions options;
        options.model = free ? RegisterOptions::Model::kFree : RegisterOptions::Model::kTurntable;
        options.prior_rotation = 0.0873;
        options.prior_translation = 0.005;
        options.max_distance = 0.015;
        const auto result = RegisterViews(views, options);
        if (ComparePoses(views, result.X_TS, truth).displacement_rms < 1e-4) ++home[free];
      }
    }
    std::printf("%-11s axis %5.1f %%  free %5.1f %%\n", name, 100.0 * home[0] / starts, 100.0 * home[1] / starts);
    std::fflush(stdout);
  }
}
