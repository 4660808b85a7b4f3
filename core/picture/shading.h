// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "core/picture/raster.h"

namespace geond {

// How open each pixel's surface lies to the space before it, 0 to 1: less in corners and folds. `radius` (m) is how far
// that looks; it looks from one pixel in each square of samples x samples, and smooths between them.
std::vector<float> Openness(const SurfaceLayer& layer, const View& view, double radius, int samples, int threads);

// The light that comes from a surface: sun from the upper left, sky, a little gloss, a bright rim, and its openness.
Color Shade(const Color& surface, const Eigen::Vector3f& normal, const Eigen::Vector3f& up, float openness);

// A soft shadow on the ground below a scene.
class GroundShadow {
 public:
  // None if the scene has no surface or the camera looks from below.
  static std::optional<GroundShadow> Of(const Scene& scene, const Camera& camera);
  // How much light the ground loses where the line of sight through a pixel meets it, 0 to 1.
  float At(const View& view, double column, double row) const;

 private:
  static constexpr int kCells = 160;
  double ground_ = 0.0, left_ = 0.0, front_ = 0.0, cell_ = 1.0;
  std::vector<float> dark_;
};

}  // namespace geond
