// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

namespace geond::reproduce {

// An axis of a plot. Without low < high its range is that of the data.
struct Axis {
  std::string label;                // with its unit
  bool log = false;
  double low = 0.0, high = 0.0;
  std::vector<std::string> names = {};  // of the places 1, 2, ...: written instead of numbers
};

// Numbers over numbers, as a line, as marks, or as bars that stand on zero.
struct Series {
  enum class Kind { kLine, kDashed, kMarks, kLineAndMarks, kBars };
  std::string name;                 // in the legend; empty: not there
  std::vector<double> x, y;         // places that are not finite (or not positive on a logarithmic axis) are left out
  Kind kind = Kind::kLine;
  int color = -1;                   // of the palette; -1: its place among the series
};

struct Plot {
  std::string title;
  Axis x, y;
  std::vector<Series> series;
  int width = 660, height = 380;    // px
};

// A closed curve in the plane, coloured by a value of each vertex, with a bar that says which colour is which value.
struct Outline {
  std::string title;
  std::string value_label;          // with its unit
  std::vector<Eigen::Vector2d> polygon;
  std::vector<double> values = {};  // a vertex; empty: drawn black
  std::vector<Eigen::Vector2d> marks = {};  // drawn as small circles over it
  std::string marks_label = {};
  int width = 420, height = 380;    // px
};

// Scalable drawings with axes, units and legend, to be set into a page as they are.
std::string ToSvg(const Plot& plot);
std::string ToSvg(const Outline& outline);

// & < > " as HTML and XML want them.
std::string Escaped(const std::string& text);

}  // namespace geond::reproduce
