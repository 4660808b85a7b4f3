// SPDX-License-Identifier: Apache-2.0
// The bunny's ten raw range scans from perturbed poses: register_bunny_validation FOLDER [degrees mm]. The poses of bun.conf
// are what the published surface was made with.
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <string>

#include "calib/conf_scan.h"
#include "calib/make_view.h"
#include "calib/pair_terms.h"
#include "calib/pose_model.h"
#include "calib/register_views.h"
#include "tests/calib/registration_case.h"
#include "tests/calib/synthetic_scan.h"

using namespace geond;
using namespace geond::calib;

int main(int argc, char** argv) {
  const std::filesystem::path folder =
      argc > 1 ? argv[1] : std::string(GEOND_SOURCE_DIR) + "/../shared/data/stanford_bunny_range";
  const double degrees = argc > 2 ? std::atof(argv[2]) : 2.0, millimetres = argc > 3 ? std::atof(argv[3]) : 5.0;
  const auto views = MakeViews(ReadConfScan(folder / "bun.conf"));
  std::vector<Pose> published;
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  double n = 0;
  for (const auto& view : views) {
    published.push_back(view.X_TS);
    const PointCloud cloud = Transform(view.X_TS, ViewCloud(view));
    for (const auto& p : cloud.points) middle += p, n += 1;
  }
  middle /= n;
  std::printf("%zu views, %.0f points\n%5s %9s %9s %9s | %9s %9s %9s %7s\n", views.size(), n, "seed", "start mm",
              "displ mm", "shape mm", "rms start", "rms end", "published", "cpu s");
  RegisterOptions keep;
  keep.model = RegisterOptions::Model::kNone;
  const double published_rms = RegisterViews(views, keep).rms_after;
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    Noise random(seed);
    std::vector<Pose> start;
    for (const auto& X : published) {
      Vector6d motion;
      motion << degrees * M_PI / 180 * random.Vector().normalized(), 1e-3 * millimetres * random.Vector().normalized();
      start.push_back(Moved(X, motion, middle, 1.0));
    }
    RegisterOptions options;
    options.model = RegisterOptions::Model::kFree;
    options.prior_rotation = degrees * M_PI / 180;
    options.prior_translation = 1e-3 * millimetres;
    options.max_distance = 0.015;
    options.rounds = 20;
    const std::clock_t clock = std::clock();
    const auto result = RegisterViews(StartingAt(views, start), options);
    const double seconds = static_cast<double>(std::clock() - clock) / CLOCKS_PER_SEC;
    const auto before = ComparePoses(views, start, published), after = ComparePoses(views, result.X_TS, published);
    std::printf("%5d %9.3f %9.3f %9.3f | %9.3f %9.3f %9.3f %7.2f\n", static_cast<int>(seed), before.displacement_rms * 1e3,
                after.displacement_rms * 1e3, after.shape_rms * 1e3, result.rms_before * 1e3, result.rms_after * 1e3,
                published_rms * 1e3, seconds);
    for (const auto& note : result.notes) std::printf("      %s\n", note.c_str());
  }
}
