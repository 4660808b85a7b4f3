// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace geond {

// Red, green, blue as they go into a picture (sRGB), 0 to 1.
using Color = Eigen::Vector3f;

// The same colour as amounts of light, and back: sums and products of light make sense, those of sRGB do not.
Color ToLight(const Color& color);
Color FromLight(const Color& light);

// A colour from OKLab in polar form (B. Ottosson, "A perceptual color space for image processing", 2020): lightness 0
// to 1, chroma from 0 (grey), hue in rad. Where the screen cannot show it, chroma is lowered until it can.
Color ColorFromLightness(double lightness, double chroma, double hue);

// A scale for values about a middle: -1 deep blue, 0 almost white, 1 deep red. Equal steps of the value look equally
// large, since each arm is a straight line in OKLab. Beyond +-1 as at it.
Color DivergingColor(double value);

// The colour of part i (from 0); neighbours in number differ much. Grey for i < 0.
Color PartColor(int part);

}  // namespace geond
