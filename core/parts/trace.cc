// SPDX-License-Identifier: Apache-2.0
// Boundary tracing and thresholding of the charge density (thesis 4.7, App. D; Fig. 6.16).
#include "core/parts/trace.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "core/parts/part_merge.h"
#include "core/parts/watershed.h"

namespace geond {
namespace {

enum class Mark : char { kFree, kSeen, kNearStart, kBoundary };  // P3, P1, P2, P0 of the thesis

class Tracer {
 public:
  Tracer(const SurfaceGraph& surface, const std::vector<double>& charge)
      : surface_(surface), charge_(charge), marks_(surface.n(), Mark::kFree), contour_(surface.n(), -1) {}

  bool MayStart(int t) const {
    if (marks_[t] != Mark::kFree) return false;
    return std::ranges::none_of(surface_.Neighbors(t),
                                [&](int next) { return (charge_[next] < charge_[t] || marks_[next] != Mark::kFree); });
  }

  void Trace(int start) {
    ++contours_;
    Take(start);
    const int first = Lowest(start, Mark::kFree);
    for (int next : surface_.Neighbors(start)) {
      if (next != first) marks_[next] = Mark::kNearStart;
    }
    if (first < 0 || OnBorder(start)) return;
    if (Walk(first) == End::kBorder) {  // an open mesh: the other way from the start
      const int second = Lowest(start, Mark::kNearStart);
      if (second >= 0) Walk(second);
    }
    for (int next : surface_.Neighbors(start)) {
      if (marks_[next] == Mark::kNearStart) marks_[next] = Mark::kSeen;
    }
  }

  std::vector<bool> Boundaries() const {
    std::vector<bool> taken(surface_.n());
    for (int t = 0; t < surface_.n(); ++t) taken[t] = marks_[t] == Mark::kBoundary;
    return taken;
  }

 private:
  enum class End { kMet, kBorder, kDead };

  void Take(int t) {
    marks_[t] = Mark::kBoundary;
    contour_[t] = contours_;
  }

  bool OnBorder(int t) const { return surface_.at_border[t]; }

  // The neighbour of least charge with this mark, or -1.
  int Lowest(int t, Mark mark) const {
    int best = -1;
    for (int next : surface_.Neighbors(t)) {
      if (marks_[next] != mark) continue;
      if (best < 0 || charge_[next] < charge_[best] || (charge_[next] == charge_[best] && next < best)) best = next;
    }
    return best;
  }

  // Beside the surroundings of the start, or beside an earlier boundary.
  bool Meets(int t) const {
    return std::ranges::any_of(surface_.Neighbors(t), [&](int next) {
      return (marks_[next] == Mark::kNearStart || (marks_[next] == Mark::kBoundary && contour_[next] != contours_));
    });
  }

  End Walk(int t) {
    for (int steps = 1;; ++steps) {
      Take(t);
      if (OnBorder(t)) return End::kBorder;
      if (steps >= 3 && Meets(t)) return End::kMet;
      int next = Lowest(t, Mark::kFree);
      if (next < 0) next = Lowest(t, Mark::kSeen);
      if (next < 0) return End::kDead;
      for (int other : surface_.Neighbors(t)) {
        if (other != next && marks_[other] == Mark::kFree) marks_[other] = Mark::kSeen;
      }
      t = next;
    }
  }

  const SurfaceGraph& surface_;
  const std::vector<double>& charge_;
  std::vector<Mark> marks_;
  std::vector<int> contour_;
  int contours_ = 0;
};

std::vector<double> AveragedCharge(const SurfaceGraph& surface, const std::vector<double>& charge) {
  return BallMean(surface, charge, std::max(0.025 * surface.size, surface.edge));
}

// Components of `keep` as parts of the whole surface.
std::vector<int> PartsFrom(const SurfaceGraph& surface, const std::vector<bool>& keep,
                           const std::vector<double>& averaged) {
  std::vector<int> labels = LabelComponents(surface, keep);
  FillUnlabelled(surface, labels);
  MergeSettings splinters;
  splinters.radius = std::max(0.04 * surface.size, 1.5 * surface.edge);
  splinters.small_area = 0.01;
  MergeRegions(surface, averaged, splinters, labels);
  return labels;
}

}  // namespace

std::vector<bool> TraceBoundaries(const SurfaceGraph& surface, const std::vector<double>& charge, double limit) {
  std::vector<int> order(surface.n());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return charge[a] < charge[b]; });
  Tracer tracer(surface, charge);
  for (int t : order) {
    if (charge[t] > limit * charge[order.front()]) break;
    if (tracer.MayStart(t)) tracer.Trace(t);
  }
  return tracer.Boundaries();
}

std::vector<int> SegmentByTracing(const SurfaceGraph& surface, const std::vector<double>& charge, double limit) {
  const std::vector<double> averaged = AveragedCharge(surface, charge);
  std::vector<bool> keep = TraceBoundaries(surface, averaged, limit);
  keep.flip();
  return PartsFrom(surface, keep, averaged);
}

std::vector<int> SegmentByThreshold(const SurfaceGraph& surface, const std::vector<double>& charge, double threshold) {
  const std::vector<double> averaged = AveragedCharge(surface, charge);
  const double least = threshold * MedianByArea(surface, averaged);
  std::vector<bool> keep(surface.n());
  for (int t = 0; t < surface.n(); ++t) keep[t] = averaged[t] >= least;
  return PartsFrom(surface, keep, averaged);
}

double MedianByArea(const SurfaceGraph& surface, const std::vector<double>& values) {
  std::vector<int> order(surface.n());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return values[a] < values[b]; });
  double below = 0.0;
  for (int t : order) {
    below += surface.areas[t];
    if (below >= 0.5 * surface.area) return values[t];
  }
  return order.empty() ? 0.0 : values[order.back()];
}

}  // namespace geond
