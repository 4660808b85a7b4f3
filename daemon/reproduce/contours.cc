// SPDX-License-Identifier: Apache-2.0
// Charge on closed curves whose density is known in closed form: in the plane it is 1/(2 pi |f'|) for unit charge, f the
// conformal map from the outside of the unit circle to that of the curve.
#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <numeric>

#include "core/base/printed.h"
#include "core/charge/contour.h"
#include "daemon/reproduce/experiments.h"
#include "daemon/reproduce/image_contour.h"

namespace geond::reproduce {
namespace {

using Complex = std::complex<double>;
using Eigen::Vector2d;
constexpr double kPi = std::numbers::pi;

ContourDensity Solve(const std::vector<Vector2d>& polygon, const Run& run) {
  ContourOptions options;
  options.threads = run.threads;
  return SolveContourCharge(polygon, options, run.stop);
}

// rms of the relative difference, % , over vertices with a density of at least `least` of the mean.
double RmsError(const std::vector<double>& density, const std::vector<double>& exact, double least) {
  const double mean = std::accumulate(exact.begin(), exact.end(), 0.0) / static_cast<double>(exact.size());
  double sum = 0.0, count = 0.0;
  for (std::size_t i = 0; i < exact.size(); ++i) {
    if (exact[i] < least * mean) continue;
    sum += std::pow(100.0 * (density[i] / exact[i] - 1.0), 2);
    count += 1.0;
  }
  return std::sqrt(sum / count);
}

struct EllipseResult {
  std::vector<double> theta, computed, exact;  // degrees; densities over their own greatest
  double rms = 0.0, worst = 0.0;               // of the difference of the two, % of the greatest
  double relative_rms = 0.0;                   // of the densities as they are, of the exact one, %
};

// Fig. 6.4 as the thesis has it: (6.1) at n equal steps of theta, both curves divided by their greatest values.
EllipseResult SolveEllipse(double d, int n, const Run& run) {
  EllipseResult result;
  std::vector<Vector2d> polygon;
  for (int i = 0; i < n; ++i) {
    const double t = 2.0 * kPi * i / n, c = std::cos(t), s = std::sin(t);
    const double r = d / std::sqrt(c * c + d * d * s * s);
    polygon.emplace_back(r * c, r * s);
    result.theta.push_back(360.0 * i / n);
    result.exact.push_back(std::sqrt((c * c + d * d * s * s) / (c * c + d * d * d * d * s * s)) / (2.0 * kPi));
  }
  result.computed = Solve(polygon, run).density;
  result.relative_rms = RmsError(result.computed, result.exact, 0.0);
  const double most = *std::max_element(result.computed.begin(), result.computed.end());
  const double most_exact = *std::max_element(result.exact.begin(), result.exact.end());
  for (int i = 0; i < n; ++i) {
    result.computed[i] /= most;
    result.exact[i] /= most_exact;
    const double difference = 100.0 * (result.computed[i] - result.exact[i]);
    result.rms += difference * difference / n;
    result.worst = std::max(result.worst, std::abs(difference));
  }
  result.rms = std::sqrt(result.rms);
  return result;
}

// 1 / length: the mean of the density of unit charge by length.
double MeanDensity(const std::vector<Vector2d>& polygon) {
  double length = 0.0;
  for (std::size_t i = 0; i < polygon.size(); ++i) length += (polygon[(i + 1) % polygon.size()] - polygon[i]).norm();
  return 1.0 / length;
}

// The share of the contour's length, %, on whose segments the density lies above (sign 1) or below (-1) a value.
double ShareOfLength(const std::vector<Vector2d>& polygon, const std::vector<double>& segment_density, double value, int sign) {
  double share = 0.0;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    if (sign * (segment_density[i] - value) > 0.0) share += (polygon[(i + 1) % polygon.size()] - polygon[i]).norm();
  }
  return 100.0 * share * MeanDensity(polygon);
}

struct Cycloid {
  std::vector<Vector2d> polygon;
  std::vector<double> exact;  // a vertex; empty if there is no closed form
};

// w + c/(m-1) w^(1-m) round the unit circle: m cusps that point outward for c = 1. Its density has a closed form.
Cycloid Hypocycloid(int n, int cusps, double c) {
  Cycloid curve;
  for (int i = 0; i < n; ++i) {
    const Complex w = std::polar(1.0, 2.0 * kPi * i / n);
    const Complex p = w + c / (cusps - 1.0) * std::pow(w, 1 - cusps);
    curve.polygon.emplace_back(p.real(), p.imag());
    curve.exact.push_back(1.0 / (2.0 * kPi * std::abs(1.0 - c * std::pow(w, -cusps))));
  }
  return curve;
}

// w - c/(m+1) w^(m+1) round the unit circle: m cusps that point inward for c = 1.
Cycloid Epicycloid(int n, int cusps, double c) {
  Cycloid curve;
  for (int i = 0; i < n; ++i) {
    const Complex w = std::polar(1.0, 2.0 * kPi * i / n);
    const Complex p = w - c / (cusps + 1.0) * std::pow(w, cusps + 1);
    curve.polygon.emplace_back(p.real(), p.imag());
  }
  return curve;
}

// The cardioid r = 2 (1 + cos phi), the epicycloid of one cusp. Inversion at the cusp makes its outside the inside of a
// parabola, which w = tan^2(pi/4 sqrt(4/z)) maps to the unit disc with infinity at its middle.
Cycloid Cardioid(int n) {
  Cycloid curve;
  for (int i = 0; i < n; ++i) {
    const double phi = 2.0 * kPi * (i + 0.5) / n - kPi;
    const Complex z = std::polar(2.0 * (1.0 + std::cos(phi)), phi);
    const Complex root = std::sqrt(4.0 / z), t = std::tan(0.25 * kPi * root);
    const Complex slope = 2.0 * t * (1.0 + t * t) * 0.25 * kPi * root / (-2.0 * z);
    curve.polygon.emplace_back(z.real(), z.imag());
    curve.exact.push_back(std::abs(slope) / (2.0 * kPi));
  }
  return curve;
}

}  // namespace

Experiment Ellipse(const Run& run) {
  Experiment e;
  e.title = "Fig. 6.4, equations (6.1) and (6.2): charge round an ellipse";
  e.what =
      "The ellipse (6.1) at 360 equal steps of theta, each density the mean of the two segments that meet there, against the "
      "closed form (6.2); the drawn curves are divided by their greatest values, as printed. The thesis says neither its ratio of axes d (here "
      "2, and 3 and 5 beside it) nor a number: \"the two curves are very similar\". The default is the thesis' own method here.";
  const std::vector<double> ratios = {2.0, 3.0, 5.0};
  Plot curves{"Charge density round the ellipse, d = 2", {"theta, degrees", false, 0, 360}, {"density / its greatest value"}, {}};
  Plot errors{"Computed less theoretical", {"theta, degrees", false, 0, 360}, {"difference, % of the greatest density"}, {}};
  for (std::size_t i = 0; i < ratios.size(); ++i) {
    run.Progress("figure_6_4", static_cast<int>(i), static_cast<int>(ratios.size()));
    const EllipseResult result = SolveEllipse(ratios[i], 360, run);
    if (i == 0) {
      curves.series = {{"theory (6.2)", result.theta, result.exact, Series::Kind::kLine},
                       {"computed", result.theta, result.computed, Series::Kind::kDashed}};
    }
    Series error{Printed("d = %.0f", ratios[i]), result.theta, {}, Series::Kind::kLine};
    for (std::size_t k = 0; k < result.theta.size(); ++k) error.y.push_back(100.0 * (result.computed[k] - result.exact[k]));
    errors.series.push_back(error);
    const auto add = [&](const char* key, const char* text, const char* unit, double value, std::optional<double> bar) {
      e.figures.push_back({Printed("%s_%.0f", key, ratios[i]), Printed("%s, d = %.0f", text, ratios[i]), unit, {}, value, value,
                           Figure::Better::kLess, 0.05, 1e-4, bar});
    };
    add("rms", "rms error of the density", "%", result.relative_rms, i == 0 ? std::optional(0.03) : std::nullopt);
    add("drawn_rms", "rms difference of the curves as drawn", "% of the greatest", result.rms, {});
    add("drawn_worst", "largest difference of the curves as drawn", "% of the greatest", result.worst, {});
  }
  e.plots = {curves, errors};
  e.judgement = Printed("The thesis' claim holds and can be given a number: %.3f %% rms at d = 2; equal steps of theta leave "
                     "few, long segments at the tips, where slender ellipses lose most (%.2f %% at d = 5).", *e.figures[0].today, *e.figures[6].today);
  return e;
}

Experiment Cycloids(const Run& run) {
  Experiment e;
  e.title = "Fig. 6.5: sharp convexities and sharp concavities";
  e.what =
      "A hypocycloid of four cusps (sharp convexities) and an epicycloid of five (sharp concavities). Both cusped curves are "
      "solved as polygons; the hypocycloid and the cardioid (the epicycloid of one cusp) have densities in closed form, so the "
      "error is known. The width of a peak is the share of the length "
      "with more than twice the mean density, that of a valley the share with less than half: the thesis says that the curve is "
      "sharper at convexities.";
  const int n = run.quick ? 400 : 1200;
  const Cycloid out = Hypocycloid(n, 4, 1.0), in = Epicycloid(n, 5, 1.0), heart = Cardioid(n), soft = Hypocycloid(n, 4, 0.9);
  run.Progress("figure_6_5", 0, 4);
  const ContourDensity out_charge = Solve(out.polygon, run);
  run.Progress("figure_6_5", 1, 4);
  const ContourDensity in_charge = Solve(in.polygon, run);
  run.Progress("figure_6_5", 2, 4);
  const ContourDensity heart_charge = Solve(heart.polygon, run);
  run.Progress("figure_6_5", 3, 4);
  const ContourDensity soft_charge = Solve(soft.polygon, run);
  const auto top = [](const std::vector<double>& d) { return std::max_element(d.begin(), d.end()) - d.begin(); };
  const auto low = [](const std::vector<double>& d) { return std::min_element(d.begin(), d.end()) - d.begin(); };
  const double peak = out_charge.density[top(out_charge.density)] / MeanDensity(out.polygon);
  const double valley = in_charge.density[low(in_charge.density)] / MeanDensity(in.polygon);
  const double convex_width =
      ShareOfLength(out.polygon, out_charge.segment_density, 2.0 * MeanDensity(out.polygon), 1) / 4.0;
  const double concave_width =
      ShareOfLength(in.polygon, in_charge.segment_density, 0.5 * MeanDensity(in.polygon), -1) / 5.0;
  const double soft_rms = RmsError(soft_charge.density, soft.exact, 0.0);
  const double heart_rms = RmsError(heart_charge.density, heart.exact, 0.01);
  using Better = Figure::Better;
  e.figures = {
      {"convex_peak", "density at the sharp convexity over the mean (theory: unbounded)", "", {}, peak, peak, Better::kMore, 0.1, 0, {}},
      {"concave_valley", "density at the sharp concavity over the mean (theory: 0)", "", 0.0, valley, valley, Better::kLess, 0.1, 1e-3, {}},
      {"convex_width", "width of the peak at one convexity", "% of the length", {}, convex_width, convex_width, Better::kSame, 0.1, 0.05, {}},
      {"concave_width", "width of the valley at one concavity", "% of the length", {}, concave_width, concave_width, Better::kSame, 0.1, 0.05, {}},
      {"hypocycloid_rms", "rms error, hypocycloid with rounded cusps (c = 0.9)", "%", {}, soft_rms, soft_rms, Better::kLess, 0.1, 1e-3, {}},
      {"cardioid_rms", "rms error, cardioid, where the density is over 1 % of the mean", "%", {}, heart_rms, heart_rms, Better::kLess, 0.1, 1e-3, {}},
  };
  const auto relative = [&](const std::vector<double>& density, double m) {
    std::vector<double> r(density);
    for (double& v : r) v /= m;
    return r;
  };
  std::vector<double> up_to_four = relative(out_charge.density, MeanDensity(out.polygon));
  for (double& v : up_to_four) v = std::min(v, 4.0);  // so that colours tell the rest apart
  e.outlines = {{"Hypocycloid, four sharp convexities (colours up to 4)", "density / mean", out.polygon, up_to_four, {}, {}},
                {"Epicycloid, five sharp concavities", "density / mean", in.polygon, relative(in_charge.density, MeanDensity(in.polygon)), {}, {}}};
  Plot plot{"Charge density along the contours", {"length along the contour, %", false, 0, 100}, {"density / mean of the contour", false, 0, 4}, {}};
  plot.series = {{"hypocycloid", ArcShare(out.polygon), relative(out_charge.density, MeanDensity(out.polygon))},
                 {"epicycloid", ArcShare(in.polygon), relative(in_charge.density, MeanDensity(in.polygon))}};
  e.plots = {plot};
  e.judgement = Printed("As printed: charge grows without bound at sharp convexities (%.0f times the mean at this resolution) and "
                     "vanishes at sharp concavities (%.3f of it); a peak takes %.1f %% of the length, a valley %.1f %%, so "
                     "peaks are indeed %s.", peak, valley, convex_width, concave_width,
                     convex_width < concave_width ? "the sharper ones" : "not the sharper ones");
  return e;
}

}  // namespace geond::reproduce
