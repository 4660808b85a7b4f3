// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/picture/raster.h"
#include "core/picture/render.h"

namespace geond {

// The scene on a canvas of `samples` times the size the options say.
Canvas DrawScene(const Scene& scene, const Camera& camera, const RenderOptions& options);

// The height of letters that suits the picture, in pixels of the canvas.
double TextHeight(const RenderOptions& options);
// A cross of the world's axes in the lower left; a bar of a round length in the lower right, true at the camera's
// target.
void DrawAxes(Canvas& canvas, const View& view, const RenderOptions& options);
void DrawScaleBar(Canvas& canvas, const View& view, const Camera& camera, const RenderOptions& options);

}  // namespace geond
