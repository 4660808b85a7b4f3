// SPDX-License-Identifier: Apache-2.0
// Seconds of one core that a simulated range image of 320 x 320 takes, scene by scene, and that its rays alone take.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <string>
#include <vector>

#include "sim/simulate_scan.h"

int main() {
  using namespace geond;
  const auto cpu = [] { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; };
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(GEOND_SOURCE_DIR "/config/scenes"))
    files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  std::printf("%-20s %8s %8s %8s %8s\n", "scene", "set up", "image", "us/ray", "returns");
  for (const auto& file : files) {
    const sim::Scene scene = sim::ReadScene(file);
    const double begin = cpu();
    const sim::SceneGeometry geometry(scene);
    const double ready = cpu();
    const StationGeometry station = sim::MakeStation();
    const RangeImage image =
        sim::TakeRangeImage(geometry, station.sensor, SensorInTurntable(station, 0.3), sim::CameraOptions{}, 1, 0, 1);
    const double end = cpu();
    const auto returns = std::count_if(image.depth.begin(), image.depth.end(), [](float z) { return !std::isnan(z); });
    std::printf("%-20s %8.3f %8.3f %8.2f %8ld\n", file.stem().c_str(), ready - begin, end - ready,
                1e6 * (end - ready) / image.depth.size(), static_cast<long>(returns));
  }
}
