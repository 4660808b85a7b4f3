// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/picture/image.h"
#include "core/picture/scene.h"

namespace geond {

struct RenderOptions {
  int columns = 800;
  int rows = 800;
  int samples = 3;  // a side of a pixel, 1 to 4: smooth edges
  Color background{1.0f, 1.0f, 1.0f};
  bool ground_shadow = true;  // a soft one, below the lowest point (z up)
  bool occlusion = true;      // corners and folds are darker
  bool axes = false;          // a small cross of x, y, z in the lower left
  bool scale_bar = false;     // with its length in mm, in the lower right
  int threads = 0;
};

// Draws the scene without display or graphics card. The same bits for any number of threads. Throws
// std::invalid_argument for a size beyond 16 to 8192 pixels, or lists of colours of the wrong length.
Image Render(const Scene& scene, const Camera& camera, const RenderOptions& options = {});

}  // namespace geond
