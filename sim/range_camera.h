// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "core/range/range_image.h"
#include "core/range/scan_folder.h"
#include "core/range/sensor_model.h"
#include "sim/scene.h"

namespace geond::sim {

// How the simulated rangefinder departs from a perfect one. The size of its noise is SensorModel::depth_noise: along
// the ray its standard deviation is depth_noise / cos(incidence) * (range / noise_distance)^2.
struct CameraOptions {
  double noise_distance = 0.450;  // m: where depth_noise holds, as triangulation's noise grows with range squared
  double dropout_begin = 1.309;   // rad of incidence: above it returns begin to fail (75 degrees) ...
  double dropout_end = 1.501;     // ... and none comes back from here on (86 degrees)
  double mixed_pixel_probability = 0.05;  // that a pixel beside a depth jump lands between its two sides
  double mixed_pixel_jump = 0.010;        // m: neighbours whose depths differ by more have a jump between them
  double depth_quantum = 2e-5;            // m: depth is a whole multiple of it, as the device counts; 0: not rounded
  static CameraOptions Perfect();         // none of it: with depth_noise = 0 the depth is exact, to a float's rounding
};

// The range image that a sensor at X_TS (true) takes of the scene. `frame` numbers the images of one seed. Every pixel
// has random numbers of its own, so the image is the same to the bit for any number of threads.
RangeImage TakeRangeImage(const SceneGeometry& scene, const SensorModel& sensor, const Pose& X_TS,
                          const CameraOptions& options, std::uint64_t seed, std::uint64_t frame, int threads = 0);

// The exact depth (m, along z of S; NaN: nothing within range) of one pixel, before any noise.
double TrueDepth(const SceneGeometry& scene, const SensorModel& sensor, const Pose& X_TS, int column, int row);

// A station by its own measures: the sensor `distance` from a point at `look_at_height` on the axis, `elevation` above
// the table's plane, with an image of columns x rows that covers `field` at that distance. The table top stands 100 mm
// over W.
StationGeometry MakeStation(double distance = 0.450, double elevation = 0.489, double look_at_height = 0.060,
                            int columns = 320, int rows = 320, double field = 0.260, double depth_noise = 0.0002);

}  // namespace geond::sim
