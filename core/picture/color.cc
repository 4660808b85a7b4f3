// SPDX-License-Identifier: Apache-2.0
#include "core/picture/color.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace geond {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

// Amounts of light of an OKLab colour; outside of 0 to 1 where no screen can show it.
Eigen::Vector3d LightFromOklab(double lightness, double a, double b) {
  const double l = lightness + 0.3963377774 * a + 0.2158037573 * b;
  const double m = lightness - 0.1055613458 * a - 0.0638541728 * b;
  const double s = lightness - 0.0894841775 * a - 1.2914855480 * b;
  const double l3 = l * l * l, m3 = m * m * m, s3 = s * s * s;
  return {4.0767416621 * l3 - 3.3077115913 * m3 + 0.2309699292 * s3,
          -1.2684380046 * l3 + 2.6097574011 * m3 - 0.3413193965 * s3,
          -0.0041960863 * l3 - 0.7034186147 * m3 + 1.7076147010 * s3};
}

}  // namespace

Color ToLight(const Color& color) {
  return color.unaryExpr([](float c) { return c <= 0.04045f ? c / 12.92f : std::pow((c + 0.055f) / 1.055f, 2.4f); });
}

Color FromLight(const Color& light) {
  return light.unaryExpr([](float c) {
    c = std::clamp(c, 0.0f, 1.0f);
    return c <= 0.0031308f ? 12.92f * c : 1.055f * std::pow(c, 1.0f / 2.4f) - 0.055f;
  });
}

Color ColorFromLightness(double lightness, double chroma, double hue) {
  double low = 0.0, high = chroma;
  const auto light = [&](double c) { return LightFromOklab(lightness, c * std::cos(hue), c * std::sin(hue)); };
  const auto shown = [&](double c) { return light(c).minCoeff() >= -1e-4 && light(c).maxCoeff() <= 1.0 + 1e-4; };
  if (shown(high)) {
    low = high;
  } else {
    for (int i = 0; i < 20; ++i) (shown(0.5 * (low + high)) ? low : high) = 0.5 * (low + high);
  }
  return FromLight(light(low).cast<float>());
}

Color DivergingColor(double value) {
  const double t = std::clamp(std::abs(value), 0.0, 1.0);
  return ColorFromLightness(0.955 - 0.475 * t, 0.165 * t, (value < 0.0 ? 256.0 : 32.0) * kDegree);
}

Color PartColor(int part) {
  if (part < 0) return Color::Constant(0.55f);
  // The golden angle never comes back to a hue it had; every other colour is darker, every third paler.
  const double hue = 250.0 + 137.50776 * part;
  return ColorFromLightness(0.70 - 0.09 * (part % 2), 0.135 - 0.03 * (part % 3 == 2), hue * kDegree);
}

}  // namespace geond
