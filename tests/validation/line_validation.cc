// SPDX-License-Identifier: Apache-2.0
// The whole line on simulated scans of the sample objects: line_validation [VIEWS [NOISE_MM [SEEDS [SCENE...]]]]; SEEDS is
// the last seed or FIRST-LAST. With GEOND_PICTURES=FOLDER in the environment a picture of each goes there. Prints a row an
// object and seed: parts and types against the truth, the worst error of a size, seconds.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>

#include "calib/make_view.h"
#include "calib/register_views.h"
#include "core/model_picture.h"
#include "core/object_model.h"
#include "sim/simulate_scan.h"

namespace geond {
namespace {

constexpr const char* kSingles[] = {"ellipsoid",      "cylinder",        "cuboid",        "tapered_cylinder",
                                    "tapered_cuboid", "curved_cylinder", "curved_cuboid"};
constexpr const char* kComposites[] = {"bowling_pin", "box_with_cylinder", "owl"};

struct Verdict {
  bool right = true;
  double size_error = 0.0;      // worst relative error of a half size
  double position_error = 0.0;  // worst, m
  std::string types;
};

Verdict Compare(const sim::Scene& scene, const ObjectDescription& description) {
  Verdict verdict;
  verdict.right = scene.parts.size() == description.parts.size();
  for (const sim::Scene::Part& part : scene.parts) {
    const Geon truth = Canonical(part.geon);
    const auto distance = [&](const DescribedPart& found) {
      return (found.geon().X_TG.translation() - truth.X_TG.translation()).norm();
    };
    const auto nearest = std::min_element(description.parts.begin(), description.parts.end(),
                                          [&](const auto& a, const auto& b) { return distance(a) < distance(b); });
    if (nearest == description.parts.end()) continue;
    verdict.right = verdict.right && nearest->geon().type == truth.type;
    for (int k = 0; k < 3; ++k) {
      verdict.size_error = std::max(verdict.size_error, std::abs(nearest->geon().size[k] / truth.size[k] - 1.0));
    }
    verdict.position_error = std::max(verdict.position_error, distance(*nearest));
  }
  for (const DescribedPart& part : description.parts) {
    verdict.types += (verdict.types.empty() ? "" : " + ") + std::string(GeonTypeName(part.geon().type));
  }
  return verdict;
}

int Run(int argc, char** argv) {
  const int views = argc > 1 ? std::atoi(argv[1]) : 4;
  const double noise_mm = argc > 2 ? std::atof(argv[2]) : 0.3;
  const std::string seeds = argc > 3 ? argv[3] : "1";
  const std::size_t dash = seeds.find('-');
  const int first_seed = dash == std::string::npos ? 1 : std::atoi(seeds.c_str());
  const int last_seed = std::atoi(seeds.c_str() + (dash == std::string::npos ? 0 : dash + 1));
  std::vector<std::string> names(argv + std::min(argc, 4), argv + argc);
  if (names.empty()) {
    names.assign(std::begin(kSingles), std::end(kSingles));
    names.insert(names.end(), std::begin(kComposites), std::end(kComposites));
  }
  int right = 0, runs = 0;
  std::printf("%-18s seed ok  size err  pos mm  reg rms mm  triangles  seconds  types\n", "object");
  for (const std::string& name : names) {
    const sim::Scene scene = sim::ReadScene(std::filesystem::path(GEOND_SOURCE_DIR) / "config/scenes" / (name + ".toml"));
    for (int seed = first_seed; seed <= last_seed; ++seed) {
      sim::SimOptions options;
      options.views = views;
      options.depth_noise = noise_mm * 1e-3;
      options.seed = static_cast<std::uint64_t>(seed);
      const RecordedScan scan = sim::SimulateScan(scene, options);
      std::vector<RangeView> range_views = calib::MakeViews(scan);
      const calib::RegistrationResult registered = calib::RegisterViews(range_views);
      for (std::size_t i = 0; i < range_views.size(); ++i) range_views[i].X_TS = registered.X_TS[i];
      const ObjectModel model = BuildObjectModel(range_views);
      const Verdict verdict = Compare(scene, model.description);
      double seconds = 0.0;
      for (const auto& [step, time] : model.description.seconds) seconds += time;
      if (const char* folder = std::getenv("GEOND_PICTURES")) {
        WritePng(ModelPicture(model, name), std::filesystem::path(folder) / (name + "_" + std::to_string(seed) + ".png"));
      }
      right += verdict.right;
      ++runs;
      std::printf("%-18s %4d %s %8.2f%% %7.2f %11.3f %10zu %8.2f  %s\n", name.c_str(), seed, verdict.right ? "ok" : "NO",
                  100 * verdict.size_error, 1e3 * verdict.position_error, 1e3 * registered.rms_after,
                  model.mesh.triangles.size(), seconds, verdict.types.c_str());
      std::fflush(stdout);
    }
  }
  std::printf("right: %d of %d\n", right, runs);
  return 0;
}

}  // namespace
}  // namespace geond

int main(int argc, char** argv) { return geond::Run(argc, argv); }
