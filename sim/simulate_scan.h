// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <stop_token>

#include "core/base/progress.h"
#include "core/range/scan_folder.h"
#include "sim/range_camera.h"
#include "sim/scene.h"
#include "sim/sim_station.h"

namespace geond::sim {

struct SimOptions {
  int views = 8;             // evenly round the table, 1 to 360
  double first_angle = 0.0;  // rad, of the table at the first view
  double distance = 0.450;   // m from the sensor to the middle of the object
  double elevation = 0.489;  // rad of the sensor over the table's plane (28 degrees)
  int columns = 320, rows = 320;
  double field = 0.0;           // m that the image covers at that distance; 0: 260 mm, more if the object needs it
  double depth_noise = 0.0002;  // m along the ray, at normal incidence and 450 mm
  CameraOptions camera;
  AxisError axis_error;
  double angle_noise = 0.0002;    // rad, standard deviation of true against read table angle, a view
  double view_rotation = 0.0;     // rad, standard deviation of an additional error of each view's pose ...
  double view_translation = 0.0;  // ... and m
  std::uint64_t seed = 1;
  int threads = 0;
};

// Scans a scene as a station would: images from the true poses, poses as an imperfect calibration tells them, and the
// truth beside. Same scene, options and seed: same bits. Throws std::invalid_argument on impossible options, and
// Cancelled.
RecordedScan SimulateScan(const Scene& scene, const SimOptions& options = {}, std::stop_token stop = {},
                          const StepObserver& on_step = {});

}  // namespace geond::sim
