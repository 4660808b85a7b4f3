// SPDX-License-Identifier: Apache-2.0
// Figs. 6.8 and 6.9: what charge tells that curvature does not: gross shape under fine wiggles, and how far a part stands out.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "core/base/printed.h"
#include "core/charge/contour.h"
#include "daemon/reproduce/experiments.h"
#include "daemon/reproduce/image_contour.h"

namespace geond::reproduce {
namespace {

using Eigen::Vector2d;
constexpr double kPi = std::numbers::pi;

std::vector<double> Charge(const std::vector<Vector2d>& polygon, const Run& run) {
  ContourOptions options;
  options.threads = run.threads;
  return SolveContourCharge(polygon, options, run.stop).density;
}

// n points evenly along a closed curve given by many.
std::vector<Vector2d> Resampled(const std::vector<Vector2d>& curve, int n) {
  std::vector<double> arc = ArcShare(curve);
  arc.push_back(100.0);
  std::vector<Vector2d> points;
  std::size_t k = 0;
  for (int i = 0; i < n; ++i) {
    const double at = 100.0 * i / n;
    while (arc[k + 1] <= at) ++k;
    const double t = (at - arc[k]) / (arc[k + 1] - arc[k]);
    points.push_back((1.0 - t) * curve[k] + t * curve[(k + 1) % curve.size()]);
  }
  return points;
}

// Cassini's oval, a dumbbell for b a little above 1, from its right end counter-clockwise.
std::vector<Vector2d> Dumbbell(double b, int n) {
  std::vector<Vector2d> fine;
  for (int i = 0; i < 8 * n; ++i) {
    const double t = 2.0 * kPi * i / (8 * n), c = std::cos(2 * t), s = std::sin(2 * t);
    const double r = std::sqrt(c + std::sqrt(b * b * b * b - s * s));
    fine.emplace_back(r * std::cos(t), r * std::sin(t));
  }
  return Resampled(fine, n);
}

std::vector<Vector2d> WithWiggles(const std::vector<Vector2d>& contour, int wiggles, double height) {
  const std::size_t n = contour.size();
  std::vector<Vector2d> wiggled;
  for (std::size_t i = 0; i < n; ++i) {
    const Vector2d along = (contour[(i + 1) % n] - contour[(i + n - 1) % n]).normalized();
    const double wave = std::cos(2.0 * kPi * wiggles * static_cast<double>(i) / static_cast<double>(n));
    wiggled.push_back(contour[i] + height * wave * Vector2d(along.y(), -along.x()));
  }
  return wiggled;
}

std::vector<double> MovingMean(const std::vector<double>& values, int width) {
  const int n = static_cast<int>(values.size());
  std::vector<double> means(n);
  for (int i = 0; i < n; ++i) {
    for (int k = 0; k < width; ++k) means[i] += values[(i + k - width / 2 + n) % n] / width;
  }
  return means;
}

double Variance(const std::vector<double>& v) {
  const double mean = std::accumulate(v.begin(), v.end(), 0.0) / static_cast<double>(v.size());
  double sum = 0.0;
  for (const double x : v) sum += (x - mean) * (x - mean);
  return sum / static_cast<double>(v.size());
}

double Correlation(const std::vector<double>& a, const std::vector<double>& b) {
  const auto n = static_cast<double>(a.size());
  const double ma = std::accumulate(a.begin(), a.end(), 0.0) / n, mb = std::accumulate(b.begin(), b.end(), 0.0) / n;
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - ma) * (b[i] - mb);
  return sum / n / std::sqrt(Variance(a) * Variance(b));
}

// The greatest value of each wiggle: the envelope of the curve.
std::vector<double> Crests(const std::vector<double>& values, int wiggles) {
  const int n = static_cast<int>(values.size()), width = n / wiggles;
  std::vector<double> crests;
  for (int w = 0; w < wiggles; ++w) {
    double most = values[w * n / wiggles];
    for (int k = -width / 2; k <= width / 2; ++k) most = std::max(most, values[(w * n / wiggles + k + n) % n]);
    crests.push_back(most);
  }
  return crests;
}

// Wiggles on whose crest the value has a local maximum.
int CrestsFound(const std::vector<double>& values, int wiggles) {
  const int n = static_cast<int>(values.size()), width = n / wiggles;
  const std::vector<int> maxima = LocalMaxima(values, width / 3);
  int found = 0;
  for (int w = 0; w < wiggles; ++w) {
    found += std::any_of(maxima.begin(), maxima.end(), [&](int at) {
      const int apart = std::abs(at - w * n / wiggles);
      return std::min(apart, n - apart) <= width / 4;
    });
  }
  return found;
}

// Peaks of an envelope: maxima that stand out by a quarter of its range from the valleys on both sides.
int EnvelopePeaks(const std::vector<double>& envelope) {
  const std::vector<double> smooth = MovingMean(envelope, 5);
  const auto [low, high] = std::minmax_element(smooth.begin(), smooth.end());
  const double need = 0.25 * (*high - *low);
  const int n = static_cast<int>(smooth.size());
  int peaks = 0;
  for (const int at : LocalMaxima(smooth, 1)) {
    bool stands = true;
    for (const int way : {1, -1}) {
      double least = smooth[at];
      bool fell = false;
      for (int k = 1; k < n && !fell && smooth[(at + way * k + n) % n] <= smooth[at]; ++k) {
        least = std::min(least, smooth[(at + way * k + n) % n]);
        fell = smooth[at] - least >= need;
      }
      stands &= fell;
    }
    peaks += stands;
  }
  return peaks;
}

// A disc with arms of equal width and round tips, longer and longer; `tips` are the middles of their ends.
std::vector<Vector2d> Hand(const std::vector<double>& lengths, std::vector<Vector2d>& tips) {
  constexpr double kHalf = 0.14;  // half the width of an arm
  std::vector<Vector2d> contour;
  const double step = 2.0 * kPi / static_cast<double>(lengths.size()), root = std::asin(kHalf);
  for (std::size_t a = 0; a < lengths.size(); ++a) {
    const double angle = step * static_cast<double>(a);
    const Vector2d out(std::cos(angle), std::sin(angle)), side(-out.y(), out.x());
    const double reach = 1.0 + lengths[a] - kHalf;
    contour.push_back(std::cos(root) * out - kHalf * side);
    for (int k = 0; k <= 16; ++k) {
      const double t = -0.5 * kPi + kPi * k / 16.0;
      contour.push_back((reach + kHalf * std::cos(t)) * out + kHalf * std::sin(t) * side);
    }
    tips.push_back((1.0 + lengths[a]) * out);
    contour.push_back(std::cos(root) * out + kHalf * side);
    for (int k = 1; k < 12; ++k) {
      const double t = angle + root + (step - 2.0 * root) * k / 12.0;
      contour.emplace_back(std::cos(t), std::sin(t));
    }
  }
  return contour;
}

std::vector<double> OverMean(std::vector<double> values) {
  const double mean = std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
  for (double& v : values) v /= mean;
  return values;
}

}  // namespace

Experiment WigglyDumbbell(const Run& run) {
  Experiment e;
  e.title = "Fig. 6.8: fine and gross structure, the wiggly dumbbell";
  e.what =
      "A dumbbell (Cassini's oval) with small waves along its outline. Fine structure: waves whose crest is a local maximum. Gross "
      "structure: peaks of the envelope of the crests (two parts, two peaks), and how much of the variance is left when each wave "
      "is averaged over.";
  const int wiggles = 60, n = run.quick ? 600 : 1200;
  const double height = 0.02;
  run.Progress("figure_6_8", 0, 2);
  const std::vector<Vector2d> smooth = Dumbbell(1.06, n), contour = WithWiggles(smooth, wiggles, height);
  const std::vector<double> charge = OverMean(Charge(contour, run));
  run.Progress("figure_6_8", 1, 2);
  const std::vector<double> gross = OverMean(Charge(smooth, run)), curvature = IncrementalCurvature(contour);
  const int width = n / wiggles;
  const std::vector<double> charge_mean = MovingMean(charge, width), curvature_mean = MovingMean(curvature, width);
  const std::vector<double> crests = Crests(charge, wiggles);
  const double charge_share = 100.0 * Variance(charge_mean) / Variance(charge);
  const double curvature_share = 100.0 * Variance(curvature_mean) / Variance(curvature);
  const double likeness = Correlation(charge_mean, gross);
  const int fine_charge = CrestsFound(charge, wiggles), fine_curvature = CrestsFound(curvature, wiggles);
  const int peaks_charge = EnvelopePeaks(crests), peaks_curvature = EnvelopePeaks(Crests(curvature, wiggles));
  using Better = Figure::Better;
  e.figures = {
      {"fine_charge", "waves found by charge", Printed("of %d", wiggles), {}, 1.0 * fine_charge, 1.0 * fine_charge, Better::kMore, 0, 1, {}},
      {"fine_curvature", "waves found by curvature", Printed("of %d", wiggles), {}, 1.0 * fine_curvature, 1.0 * fine_curvature, Better::kFree, 0, 0, {}},
      {"peaks_charge", "peaks of the envelope of charge", "", 2.0, 1.0 * peaks_charge, 1.0 * peaks_charge, Better::kSame, 0, 0, {}},
      {"peaks_curvature", "peaks of the envelope of curvature", "", {}, 1.0 * peaks_curvature, 1.0 * peaks_curvature, Better::kFree, 0, 0, {}},
      {"gross_charge", "variance of charge that is gross structure", "%", {}, charge_share, charge_share, Better::kMore, 0.1, 0, {}},
      {"gross_curvature", "variance of curvature that is gross structure", "%", {}, curvature_share, curvature_share, Better::kFree, 0, 0, {}},
      {"likeness", "correlation of charge, each wave averaged over, with that of the dumbbell without waves", "", {}, likeness, likeness, Better::kMore, 0, 0.02, {}},
  };
  const std::vector<double> arc = ArcShare(contour);
  Series envelope{"envelope", {}, {}, Series::Kind::kDashed, 1};
  for (int w = 0; w <= wiggles; ++w) {
    envelope.x.push_back(100.0 * w / wiggles);
    envelope.y.push_back(crests[w % wiggles]);
  }
  const Axis along{"length along the contour, %", false, 0, 100};
  e.outlines = {{"The dumbbell, by charge density", "density / mean", contour, charge}};
  e.plots = {{"Charge density along the dumbbell", along, {"density / mean"}, {{"charge density", arc, charge, Series::Kind::kLine, 0}, envelope}},
             {"Incremental curvature along the dumbbell", along, {"curvature, 1 / unit of length"}, {{"curvature", arc, curvature, Series::Kind::kLine, 0}}}};
  e.judgement = Printed("As printed: charge shows all %d waves and the two lobes at once (%.0f %% of its variance is gross shape, the "
                     "envelope has %d peaks), where of the variance of curvature %.1f %% is gross shape.",
                     fine_charge, charge_share, peaks_charge, curvature_share);
  return e;
}

Experiment PartSignificance(const Run& run) {
  Experiment e;
  e.title = "Fig. 6.9: charge and the significance of parts";
  e.what =
      "A disc with five arms of equal width and tip and of different length, as an image contour of 60 pixels a radius after "
      "a low-pass of 0.3 % (the 2 % of the thesis would sharpen arms as thin as these). How well does the height of the peak on each arm follow its length?";
  const std::vector<double> lengths = {0.3, 1.2, 0.6, 1.5, 0.9};
  std::vector<Vector2d> tips;
  const std::vector<Vector2d> polygon = Hand(lengths, tips);
  run.Progress("figure_6_9", 0, 1);
  Vector2d low(1e9, 1e9);
  for (const Vector2d& p : polygon) low = low.cwiseMin(p);
  const double pixels = run.quick ? 40.0 : 60.0;
  const std::vector<Vector2d> contour = LowPass(PixelContour(polygon, pixels), 0.3);
  const std::vector<double> charge = OverMean(Charge(contour, run)), curvature = IncrementalCurvature(contour);
  std::vector<double> charge_peaks, curvature_peaks;
  for (const Vector2d& tip : tips) {
    const Vector2d at = (tip - low) * pixels + Vector2d(2, 2);
    double most_charge = 0.0, most_curvature = 0.0;
    for (std::size_t i = 0; i < contour.size(); ++i) {
      if ((contour[i] - at).norm() > 0.28 * pixels) continue;
      most_charge = std::max(most_charge, charge[i]);
      most_curvature = std::max(most_curvature, curvature[i]);
    }
    charge_peaks.push_back(most_charge);
    curvature_peaks.push_back(most_curvature);
  }
  const double by_charge = Correlation(lengths, charge_peaks), by_curvature = Correlation(lengths, curvature_peaks);
  e.figures = {{"charge", "correlation of the peak of charge with the length of the arm", "", {}, by_charge, by_charge, Figure::Better::kMore, 0, 0.03, {}},
               {"curvature", "correlation of the peak of curvature with the length of the arm", "", {}, by_curvature, by_curvature, Figure::Better::kFree, 0, 0, {}}};
  const Axis along{"length along the contour, %", false, 0, 100};
  e.outlines = {{"The contour, by charge density", "density / mean", contour, charge}};
  e.plots = {{"Charge density along the contour", along, {"density / mean"}, {{"", ArcShare(contour), charge}}},
             {"Incremental curvature along the contour", along, {"curvature, 1 / pixel"}, {{"", ArcShare(contour), curvature}}},
             {"Peak on each arm over its length", {"length of the arm, radii of the disc"}, {"peak / the greatest of the five", false, 0, 1.1}, {}}};
  Series charges{"charge", lengths, charge_peaks, Series::Kind::kMarks}, curvatures{"curvature", lengths, curvature_peaks, Series::Kind::kMarks};
  for (Series* s : {&charges, &curvatures}) {
    const double most = *std::max_element(s->y.begin(), s->y.end());
    for (double& y : s->y) y /= most;
  }
  e.plots.back().series = {charges, curvatures};
  e.judgement = Printed("%s: the longer an arm, the higher its peak of charge (correlation %.2f); curvature, equal at all tips, "
                     "says %s (%.2f).", by_charge > 0.8 ? "As printed" : "Less clearly than printed", by_charge, std::abs(by_curvature) < 0.5 ? "nothing of it" : "little of it that is not chance", by_curvature);
  return e;
}

}  // namespace geond::reproduce
