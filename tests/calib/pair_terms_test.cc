// SPDX-License-Identifier: Apache-2.0
#include "calib/pair_terms.h"

#include <Eigen/Cholesky>
#include <gtest/gtest.h>

#include "calib/make_view.h"
#include "calib/pose_model.h"
#include "tests/calib/synthetic_scan.h"

namespace geond::calib {
namespace {

constexpr double kLength = 0.04;

struct TwoViews {
  std::vector<ViewPoints> ready;
  std::vector<RangeView> views;
  std::vector<Pose> X_TS;
};

TwoViews Pair(double noise, std::uint64_t seed) {
  TwoViews pair;
  pair.views = MakeViews(SyntheticScan(BoxAndSphere(), 8, noise, seed));
  for (int k = 0; k < 2; ++k) {
    pair.ready.push_back(ReadyForRegistration(pair.views[k]));
    pair.X_TS.push_back(pair.views[k].X_TS);
  }
  return pair;
}

Eigen::Vector3d Middle() { return {0.0, 0.0, 0.03}; }

Vector6d SomeMotion(double size) {
  Vector6d motion;
  motion << 0.5, -0.4, 0.3, -0.3, 0.4, 0.5;
  return size * motion.normalized();
}

TEST(ComparePair, GradientIsTheDifferenceQuotientOfTheLoss) {
  const TwoViews pair = Pair(0.0, 1);
  PairOptions options;
  options.samples = 100000;
  std::vector<Pose> at = pair.X_TS;
  at[0] = Moved(at[0], SomeMotion(0.0005), Middle(), kLength);
  const PairTerm here = ComparePair(pair.ready, at, 0, 1, Middle(), kLength, options);
  const double h = 2e-5;
  for (int k = 0; k < 6; ++k) {
    Vector6d step = Vector6d::Zero();
    step[k] = h;
    auto plus = at, minus = at;
    plus[0] = Moved(at[0], step, Middle(), kLength);
    minus[0] = Moved(at[0], -step, Middle(), kLength);
    // Per point that meets: moving changes which points meet at the rim.
    const PairTerm more = ComparePair(pair.ready, plus, 0, 1, Middle(), kLength, options);
    const PairTerm less = ComparePair(pair.ready, minus, 0, 1, Middle(), kLength, options);
    const double quotient = here.points * 0.5 * (more.loss / more.points - less.loss / less.points) / (2.0 * h);
    EXPECT_NEAR(here.g[k], quotient, 0.05 * here.g.norm()) << "motion " << k;
  }
}

// How far the surfaces lie apart along their normals, rms, after a small motion of one view.
double Apart(const PairTerm& term, const Vector6d& motion, double scale) {
  return std::sqrt(motion.dot(term.H * motion) / term.weight) * scale;
}

TEST(ComparePair, OneStepBringsAMovedViewHome) {
  for (const double noise : {0.0, 0.0002}) {
    const TwoViews pair = Pair(noise, 3);
    PairOptions options;
    options.samples = 100000;
    const Vector6d off = SomeMotion(0.0006);
    std::vector<Pose> at = pair.X_TS;
    at[0] = Moved(at[0], off, Middle(), kLength);
    const PairTerm term = ComparePair(pair.ready, at, 0, 1, Middle(), kLength, options);
    const Vector6d step = (term.H - term.noise).ldlt().solve(-term.g);
    // What is left: robust weights, and points that met another face of the object before they were moved.
    EXPECT_LT(Apart(term, off + step, options.scale), 0.2 * Apart(term, off, options.scale)) << "noise " << noise;
  }
}

}  // namespace
}  // namespace geond::calib
