// SPDX-License-Identifier: Apache-2.0
#include "daemon/reproduce/plot.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/base/printed.h"
#include "core/picture/color.h"
#include "daemon/reproduce/experiment.h"

namespace geond::reproduce {
namespace {

// Colours that people who do not see red or green tell apart (Okabe and Ito), the yellow left out for white paper.
constexpr std::array kPalette = {"#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#7f5f00", "#555555", "#e69f00"};

const char* PaletteColor(int i) { return kPalette[static_cast<std::size_t>(i) % kPalette.size()]; }

// The room of the curves, and how a value becomes a place on the paper.
class Scale {
 public:
  Scale(const Axis& axis, const std::vector<Series>& series, bool is_x, double begin, double end)
      : log_(axis.log), begin_(begin), end_(end) {
    double low = std::numeric_limits<double>::infinity(), high = -low;
    bool bars = false;
    for (const Series& s : series) {
      for (const double v : is_x ? s.x : s.y) {
        if (!std::isfinite(v) || (log_ && v <= 0.0)) continue;
        low = std::min(low, v);
        high = std::max(high, v);
      }
      bars |= s.kind == Series::Kind::kBars;
    }
    if (axis.high > axis.low) {
      low_ = Place(axis.low), high_ = Place(axis.high);
    } else {
      if (!(low <= high)) low = log_ ? 1.0 : 0.0, high = log_ ? 10.0 : 1.0;
      if (bars && !is_x && !log_) low = std::min(low, 0.0);
      low_ = Place(low), high_ = Place(high);
      const double margin = high_ > low_ ? 0.04 * (high_ - low_) : 0.5;
      if (!axis.names.empty()) low_ = 0.4, high_ = static_cast<double>(axis.names.size()) + 0.6;
      else if (!(bars && !is_x && low == 0.0)) low_ -= margin;
      if (axis.names.empty()) high_ += margin;
    }
  }

  bool Takes(double v) const { return std::isfinite(v) && (!log_ || v > 0.0); }
  double operator()(double v) const { return begin_ + (end_ - begin_) * (Place(v) - low_) / (high_ - low_); }
  bool Inside(double v) const { return Takes(v) && Place(v) >= low_ - 1e-9 && Place(v) <= high_ + 1e-9; }
  double low() const { return log_ ? std::pow(10.0, low_) : low_; }

  // Round values across the range.
  std::vector<double> Ticks() const {
    std::vector<double> ticks;
    if (log_) {
      const int decades = static_cast<int>(std::floor(high_) - std::ceil(low_)) + 1;
      const std::vector<double> digits = decades <= 1 ? std::vector<double>{1, 2, 3, 5} :
                                         decades <= 2 ? std::vector<double>{1, 2, 5} : std::vector<double>{1};
      const int every = std::max(1, decades / 6);
      for (int d = static_cast<int>(std::floor(low_)); d <= static_cast<int>(std::ceil(high_)); d += 1) {
        if (d % every != 0) continue;
        for (const double digit : digits) ticks.push_back(digit * std::pow(10.0, d));
      }
    } else {
      const double rough = (high_ - low_) / 5.0, power = std::pow(10.0, std::floor(std::log10(rough)));
      const double share = rough / power;
      const double step = power * (share < 1.5 ? 1.0 : share < 3.5 ? 2.0 : share < 7.5 ? 5.0 : 10.0);
      for (double k = std::ceil(low_ / step); k * step <= high_; k += 1.0) ticks.push_back(k * step);
    }
    std::erase_if(ticks, [this](double v) { return !Inside(v); });
    return ticks;
  }

 private:
  double Place(double v) const { return log_ ? std::log10(v) : v; }
  bool log_;
  double begin_, end_, low_ = 0.0, high_ = 1.0;
};

std::string Number(double v) { return std::abs(v) < 1e-12 ? "0" : Printed("%.4g", v); }

std::string Head(int width, int height) {
  return Printed("<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 %d %d\" width=\"%d\" height=\"%d\" "
              "font-family=\"system-ui,sans-serif\" font-size=\"12\">\n", width, height, width, height);
}

std::string Words(double x, double y, const std::string& text, const char* more = "") {
  return Printed("<text x=\"%.1f\" y=\"%.1f\" %s>", x, y, more) + Escaped(text) + "</text>\n";
}

constexpr double kTop = 34.0, kBottom = 50.0, kLeft = 66.0, kLegend = 17.0;

// How wide a text is, about.
double Width(const std::string& text) { return 6.4 * static_cast<double>(text.size()); }

double LegendWidth(const Plot& plot) {
  double width = 0.0;
  for (const Series& s : plot.series) {
    if (!s.name.empty()) width = std::max(width, 40.0 + Width(s.name));
  }
  return width;
}

std::string Axes(const Plot& plot, const Scale& x, const Scale& y, double right, double bottom) {
  std::string svg;
  for (const double v : y.Ticks()) {
    svg += Printed("<path d=\"M%.1f %.1fH%.1f\" stroke=\"#e3e3e3\"/>\n", kLeft, y(v), right);
    svg += Words(kLeft - 6, y(v) + 4, Number(v), "text-anchor=\"end\"");
  }
  if (plot.x.names.empty()) {
    for (const double v : x.Ticks()) {
      svg += Printed("<path d=\"M%.1f %.1fV%.1f\" stroke=\"#e3e3e3\"/>\n", x(v), kTop, bottom);
      svg += Words(x(v), bottom + 16, Number(v), "text-anchor=\"middle\"");
    }
  }
  for (std::size_t i = 0; i < plot.x.names.size(); ++i) {
    svg += Words(x(static_cast<double>(i + 1)), bottom + 16, plot.x.names[i], "text-anchor=\"middle\"");
  }
  svg += Printed("<path d=\"M%.1f %.1fV%.1fH%.1f\" fill=\"none\" stroke=\"#333\"/>\n", kLeft, kTop, bottom, right);
  svg += Words(0.5 * (kLeft + right), bottom + 38, plot.x.label, "text-anchor=\"middle\"");
  const double middle = 0.5 * (kTop + bottom);
  svg += Words(16, middle, plot.y.label, Printed("text-anchor=\"middle\" transform=\"rotate(-90 16 %.1f)\"", middle).c_str());
  svg += Words(kLeft, 20, plot.title, "font-weight=\"600\" font-size=\"13\"");
  return svg;
}

std::string Curve(const Series& s, const Scale& x, const Scale& y, const char* color, int bar, int bars) {
  std::string svg, path;
  const bool marks = s.kind == Series::Kind::kMarks || s.kind == Series::Kind::kLineAndMarks;
  const bool line = s.kind != Series::Kind::kMarks && s.kind != Series::Kind::kBars;
  bool pen = false;
  for (std::size_t i = 0; i < std::min(s.x.size(), s.y.size()); ++i) {
    if (!x.Takes(s.x[i]) || !y.Takes(s.y[i])) {
      pen = false;
      continue;
    }
    const double px = x(s.x[i]), py = y(s.y[i]);
    if (s.kind == Series::Kind::kBars) {
      const double step = 0.8 * (x(1.0) - x(0.0)) / bars, base = y(std::max(0.0, y.low()));
      svg += Printed("<rect x=\"%.1f\" y=\"%.1f\" width=\"%.1f\" height=\"%.1f\" fill=\"%s\"/>\n",
                  px - 0.4 * (x(1.0) - x(0.0)) + bar * step, std::min(py, base), 0.92 * step, std::abs(base - py), color);
    }
    if (line) path += Printed("%c%.1f %.1f", pen ? 'L' : 'M', px, py);
    pen = true;
    if (marks) svg += Printed("<circle cx=\"%.1f\" cy=\"%.1f\" r=\"3.2\" fill=\"%s\" fill-opacity=\"0.8\"/>\n", px, py, color);
  }
  if (line) {
    svg += "<path d=\"" + path + Printed("\" fill=\"none\" stroke=\"%s\" stroke-width=\"1.6\"%s/>\n", color,
                                      s.kind == Series::Kind::kDashed ? " stroke-dasharray=\"6 4\"" : "");
  }
  return svg;
}

std::string Legend(const Series& s, double x, double y, const char* color) {
  std::string svg;
  if (s.kind == Series::Kind::kBars) {
    svg += Printed("<rect x=\"%.1f\" y=\"%.1f\" width=\"20\" height=\"10\" fill=\"%s\"/>\n", x, y - 9, color);
  } else if (s.kind != Series::Kind::kMarks) {
    svg += Printed("<path d=\"M%.1f %.1fh20\" stroke=\"%s\" stroke-width=\"2\"%s/>\n", x, y - 4, color,
                s.kind == Series::Kind::kDashed ? " stroke-dasharray=\"6 4\"" : "");
  }
  if (s.kind == Series::Kind::kMarks || s.kind == Series::Kind::kLineAndMarks) {
    svg += Printed("<circle cx=\"%.1f\" cy=\"%.1f\" r=\"3.2\" fill=\"%s\"/>\n", x + 10, y - 4, color);
  }
  return svg + Words(x + 27, y, s.name);
}

// From deep violet, low, over green to yellow, high; lightness grows evenly.
std::string ValueColor(double share) {
  const double t = std::clamp(share, 0.0, 1.0);
  const Color c = 255.0f * ColorFromLightness(0.30 + 0.58 * t, 0.13, (300.0 - 200.0 * t) * M_PI / 180.0);
  return Printed("#%02x%02x%02x", static_cast<int>(c[0]), static_cast<int>(c[1]), static_cast<int>(c[2]));
}

}  // namespace

std::string Escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&': out += "&amp;"; break;
      case '<': out += "&lt;"; break;
      case '>': out += "&gt;"; break;
      case '"': out += "&quot;"; break;
      default: out += c;
    }
  }
  return out;
}

std::string ToSvg(const Plot& plot) {
  const double legend = LegendWidth(plot);
  const double right = plot.width - (legend > 0.0 ? legend + 12.0 : 16.0), bottom = plot.height - kBottom;
  const Scale x(plot.x, plot.series, true, kLeft, right), y(plot.y, plot.series, false, bottom, kTop);
  std::string svg = Head(plot.width, plot.height) + Axes(plot, x, y, right, bottom);
  // A drawing within the drawing cuts off what leaves the range of the axes.
  svg += Printed("<svg x=\"%.1f\" y=\"%.1f\" width=\"%.1f\" height=\"%.1f\" viewBox=\"%.1f %.1f %.1f %.1f\">\n", kLeft, kTop - 4,
              right - kLeft + 4, bottom - kTop + 4, kLeft, kTop - 4, right - kLeft + 4, bottom - kTop + 4);
  const auto bars = static_cast<int>(std::count_if(plot.series.begin(), plot.series.end(), [](const Series& s) {
    return s.kind == Series::Kind::kBars;
  }));
  int bar = 0;
  std::string legends;
  double line = kTop + 12.0;
  for (std::size_t i = 0; i < plot.series.size(); ++i) {
    const Series& s = plot.series[i];
    const char* color = PaletteColor(s.color >= 0 ? s.color : static_cast<int>(i));
    svg += Curve(s, x, y, color, bar, bars);
    bar += s.kind == Series::Kind::kBars;
    if (s.name.empty()) continue;
    legends += Legend(s, right + 12.0, line, color);
    line += kLegend;
  }
  return svg + "</svg>\n" + legends + "</svg>\n";
}

std::string ToSvg(const Outline& outline) {
  std::string svg = Head(outline.width, outline.height);
  svg += Words(12, 20, outline.title, "font-weight=\"600\" font-size=\"13\"");
  if (outline.polygon.empty()) return svg + "</svg>\n";
  Eigen::Vector2d low = outline.polygon[0], high = low;
  for (const Eigen::Vector2d& p : outline.polygon) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const bool valued = outline.values.size() == outline.polygon.size();
  const double left = 14.0, top = 34.0, room_x = outline.width - left - (valued ? 92.0 : 14.0);
  const double room_y = outline.height - top - 14.0 - (outline.marks.empty() ? 0.0 : 20.0);
  const double scale = std::min(room_x / std::max(1e-12, high.x() - low.x()), room_y / std::max(1e-12, high.y() - low.y()));
  const auto at = [&](const Eigen::Vector2d& p) -> Eigen::Vector2d {
    return {left + scale * (p.x() - low.x()), top + scale * (high.y() - p.y())};
  };
  double least = 0.0, most = 1.0;
  if (valued) {
    least = *std::min_element(outline.values.begin(), outline.values.end());
    most = *std::max_element(outline.values.begin(), outline.values.end());
  }
  const std::size_t n = outline.polygon.size();
  for (std::size_t i = 0; i < n; ++i) {
    const Eigen::Vector2d a = at(outline.polygon[i]), b = at(outline.polygon[(i + 1) % n]);
    const double value = valued ? 0.5 * (outline.values[i] + outline.values[(i + 1) % n]) : 0.0;
    svg += Printed("<path d=\"M%.1f %.1fL%.1f %.1f\" stroke=\"%s\" stroke-width=\"%s\" stroke-linecap=\"round\"/>\n", a.x(), a.y(),
                b.x(), b.y(), valued ? ValueColor((value - least) / std::max(1e-300, most - least)).c_str() : "#333",
                valued ? "4" : "1.5");
  }
  for (const Eigen::Vector2d& mark : outline.marks) {
    const Eigen::Vector2d p = at(mark);
    svg += Printed("<circle cx=\"%.1f\" cy=\"%.1f\" r=\"4.5\" fill=\"none\" stroke=\"#d55e00\" stroke-width=\"1.6\"/>\n", p.x(), p.y());
  }
  if (!outline.marks.empty()) {
    svg += Printed("<circle cx=\"20\" cy=\"%d\" r=\"4.5\" fill=\"none\" stroke=\"#d55e00\" stroke-width=\"1.6\"/>\n", outline.height - 12);
    svg += Words(30, outline.height - 8, outline.marks_label);
  }
  if (valued) {
    const double x = outline.width - 84.0, height = room_y - 40.0;
    for (int k = 0; k < 40; ++k) {
      svg += Printed("<rect x=\"%.1f\" y=\"%.1f\" width=\"14\" height=\"%.1f\" fill=\"%s\"/>\n", x, top + height * (1.0 - (k + 1) / 40.0),
                  height / 40.0 + 0.6, ValueColor((k + 0.5) / 40.0).c_str());
    }
    for (int k = 0; k <= 4; ++k) {
      svg += Words(x + 19, top + height * (1.0 - k / 4.0) + 4.0, Printed("%.3g", least + (most - least) * k / 4.0));
    }
    svg += Words(outline.width - 6, top + height + 24.0, outline.value_label, "text-anchor=\"end\"");
  }
  return svg + "</svg>\n";
}

}  // namespace geond::reproduce
