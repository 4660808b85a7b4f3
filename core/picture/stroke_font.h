// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>
#include <vector>

#include <Eigen/Core>

namespace geond {

// A letter drawn with a pen: lines through points, x to the right, y down from the height of capitals (0) over the
// small letters (2) to the line they stand on (6) and what hangs below it (8).
using Stroke = std::vector<Eigen::Vector2d>;

// The strokes of a text in units of the font (capitals are 6 high), beginning at the origin, and how wide it is.
// Characters beyond printable ASCII, the degree sign and the multiplication sign (UTF-8) appear as boxes.
std::vector<Stroke> TextStrokes(std::string_view text);
double TextWidth(std::string_view text);

}  // namespace geond
