// SPDX-License-Identifier: Apache-2.0
// Errors of joint registration on recorded cases with known poses: register_cases_validation FOLDER (one case a subfolder).
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <filesystem>

#include "calib/register_views.h"
#include "tests/calib/registration_case.h"

using namespace geond;
using namespace geond::calib;

int main(int argc, char** argv) {
  const std::filesystem::path folder =
      argc > 1 ? argv[1] : std::string(GEOND_SOURCE_DIR) + "/../shared/cases/registration";
  std::vector<std::filesystem::path> cases;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) cases.push_back(entry.path());
  std::sort(cases.begin(), cases.end());
  std::printf("%-12s %-10s %-6s %9s %9s %9s %9s %9s %6s %6s %s\n", "case", "start", "model", "start mm", "displ mm",
              "normal mm", "shape mm", "rms mm", "cpu s", "rounds", "used");
  for (const auto& path : cases) {
    const RegistrationCase data = ReadRegistrationCase(path);
    for (const bool perturbed : {false, true}) {
      const auto& start = perturbed ? data.X_TS_perturbed : data.X_TS_axis;
      const auto views = StartingAt(data.views, start);
      for (const auto model : {RegisterOptions::Model::kTurntable, RegisterOptions::Model::kFree,
                               RegisterOptions::Model::kAuto}) {
        RegisterOptions options;
        options.model = model;
        const std::clock_t clock = std::clock();
        const auto result = RegisterViews(views, options);
        const double seconds = static_cast<double>(std::clock() - clock) / CLOCKS_PER_SEC;
        const auto before = ComparePoses(views, start, data.X_TS_true);
        const auto after = ComparePoses(views, result.X_TS, data.X_TS_true);
        const char* names[] = {"auto", "axis", "free", "none"};
        std::printf("%-12s %-10s %-6s %9.3f %9.4f %9.4f %9.4f %9.4f %6.2f %6d %s%s\n", path.filename().c_str(),
                    perturbed ? "perturbed" : "axis", names[static_cast<int>(model)], before.displacement_rms * 1e3,
                    after.displacement_rms * 1e3, after.normal_rms * 1e3, after.shape_rms * 1e3, result.rms_after * 1e3, seconds,
                    result.summary.iterations, names[static_cast<int>(result.model)],
                    result.summary.converged ? "" : " (not converged)");
        for (const auto& note : result.notes) std::printf("    %s\n", note.c_str());
      }
    }
  }
}
