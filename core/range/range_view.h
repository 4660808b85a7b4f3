// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "core/geometry/point_cloud.h"
#include "core/geometry/pose.h"
#include "core/range/range_image.h"
#include "core/range/sensor_model.h"

namespace geond {

// What a pixel of a view is.
enum class PixelClass : std::uint8_t {
  kNothing = 0,     // no return: unknown (absorbed, grazing, out of range)
  kObject = 1,      // on the object
  kRejected = 2,    // on the object, but not to be trusted (depth jump, grazing)
  kTable = 3,       // on the table: free space up to there
  kBackground = 4,  // beyond the work space: free space up to there
};

// One range image cut from its background, with normals, and where the sensor stood. All lists are one a pixel, row by
// row.
struct RangeView {
  SensorModel sensor;
  RangeImage image;  // every return, also of table and background
  std::vector<PixelClass> classes;
  std::vector<Eigen::Vector3f> normals_S;  // unit, towards the sensor; NaN where none could be fitted
  std::vector<float> normal_residuals;     // rms of the plane fit, m; NaN where none
  double table_angle = 0.0;                // rad
  Pose X_TS_measured;                      // from calibration and table angle
  Pose X_TS;                               // refined by registration; as measured until then

  bool IsObject(std::size_t pixel) const { return classes[pixel] == PixelClass::kObject; }
};

// Points and normals of the object pixels of a view that have a normal, with the residuals of the fit, in S, in the
// order of the pixels.
PointCloud ViewCloud(const RangeView& view);

struct NormalOptions {
  int window = 5;  // pixels a side, odd, >= 3
  double max_depth_jump =
      0.0;  // m: neighbours further than this along z from the centre do not take part; 0: six times
            // the depth noise plus the depth change of a surface at max_incidence over as many pixels
  double max_incidence = 1.45;  // rad, angle of normal and line of sight: above it a pixel is rejected as grazing
  int min_neighbors = 5;        // beside the pixel itself; fewer (or all in a line): no normal, pixel rejected
};

// The view with a plane fitted to the neighbourhood of every object pixel (least squares, thesis 6.1): normals_S and
// normal_residuals are set, pixels without a trustworthy normal become kRejected. The same bits for any number of
// threads. Throws std::invalid_argument if lists and image do not agree in size or an option is out of its range.
RangeView EstimateNormals(RangeView view, const NormalOptions& options = {}, int threads = 0);

}  // namespace geond
