// SPDX-License-Identifier: Apache-2.0
#include "core/geon/starts.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>

namespace geond {
namespace {

constexpr double kQuarter = 1.5707963267948966;
constexpr double kLittle = 0.12;   // taper, or half bending angle, of starts from the base type

Eigen::Vector3d PointAt(const LanePoints& p, int i) { return {p.point[0][i], p.point[1][i], p.point[2][i]}; }
Eigen::Vector3d NormalAt(const LanePoints& p, int i) { return {p.normal[0][i], p.normal[1][i], p.normal[2][i]}; }

Eigen::Matrix3d RightHanded(Eigen::Matrix3d m) {
  if (m.determinant() < 0.0) m.col(2) = -m.col(2);
  return m;
}

Eigen::Matrix3d PrincipalAxes(const Eigen::Matrix3d& scatter) {
  return RightHanded(Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(scatter).eigenvectors());
}

// Climbs sum over axes and normals of (n . u)^4 from a rotation: the nearest rotation to its slope, again and again.
std::pair<Eigen::Matrix3d, double> ClimbQuartic(const LanePoints& points, Eigen::Matrix3d axes) {
  double height = 0.0;
  for (int step = 0; step < 30; ++step) {
    Eigen::Matrix3d slope = Eigen::Matrix3d::Zero();
    double sum = 0.0;
    for (int i = 0; i < points.size; ++i) {
      const Eigen::Vector3d n = NormalAt(points, i), c = axes.transpose() * n;
      const Eigen::Vector3d cube = c.array().cube();
      slope += n * cube.transpose();
      sum += cube.dot(c);
    }
    if (sum <= height * (1.0 + 1e-9)) break;
    height = sum;
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(slope, Eigen::ComputeFullU | Eigen::ComputeFullV);
    axes = RightHanded(svd.matrixU() * svd.matrixV().transpose());
  }
  return {axes, height};
}

// Whether two frames have the same axes up to order and sign, within some degrees.
bool SameAxes(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b) {
  const Eigen::Matrix3d cosine = (a.transpose() * b).cwiseAbs();
  return cosine.rowwise().maxCoeff().minCoeff() > 0.997;
}

struct Extent {
  Eigen::Vector3d low, high;   // along the axes of a frame
};

Extent ExtentIn(const Eigen::Matrix3d& axes, const LanePoints& points) {
  Extent e{Eigen::Vector3d::Constant(1e300), Eigen::Vector3d::Constant(-1e300)};
  for (int i = 0; i < points.size; ++i) {
    const Eigen::Vector3d p = axes.transpose() * PointAt(points, i);
    e.low = e.low.cwiseMin(p);
    e.high = e.high.cwiseMax(p);
  }
  return e;
}

GeonState Straight(GeonType type, const Eigen::Matrix3d& axes, const Extent& extent) {
  GeonState s;
  s.type = type;
  s.rotation = axes;
  s.center = axes * (0.5 * (extent.low + extent.high));
  s.size = (0.5 * (extent.high - extent.low)).cwiseMax(0.01);
  return s;
}

// A bend of half angle `theta` towards +x that fills the extent: chord along z, rise along x.
GeonState Bent(GeonType type, const Eigen::Matrix3d& axes, const Extent& extent, double theta) {
  GeonState s = Straight(type, axes, extent);
  const double width = extent.high.x() - extent.low.x(), half_chord = s.size.z();
  const double sine = std::sin(theta), rise = 1.0 - std::cos(theta);
  double ax = width / 4.0, radius = 1.0;
  for (int i = 0; i < 4; ++i) {
    radius = std::max(half_chord / sine - ax, 1.2 * ax);
    ax = std::clamp((width - rise * radius) / (2.0 - rise), 0.12 * width, 0.5 * width);
  }
  s.size.x() = ax;
  s.size.z() = theta * radius;
  s.deformation[0] = 1.0 / radius;
  const Eigen::Vector3d middle = 0.5 * (extent.low + extent.high);
  s.center = axes * Eigen::Vector3d(extent.low.x() + ax, middle.y(), middle.z());
  return s;
}

// Starts that fill the extent of the points.
std::vector<GeonState> StartsInside(GeonType type, const std::vector<Eigen::Matrix3d>& frames, const LanePoints& points) {
  std::vector<GeonState> starts;
  const bool any_axis = type != GeonType::kEllipsoid && type != GeonType::kCuboid;
  for (const Eigen::Matrix3d& frame : frames) {
    for (int axis = 0; axis < (any_axis ? 3 : 1); ++axis) {
      // The axis to z, the two others behind it in order.
      Eigen::Matrix3d axes;
      axes << frame.col((axis + 1) % 3), frame.col((axis + 2) % 3), frame.col(axis);
      if (IsCurved(type)) {
        for (int quarter = 0; quarter < 4; ++quarter) {
          const Eigen::Matrix3d turned = axes * Eigen::AngleAxisd(quarter * kQuarter, Eigen::Vector3d::UnitZ());
          const Extent extent = ExtentIn(turned, points);
          for (const double theta : {0.5, 1.2}) starts.push_back(Bent(type, turned, extent, theta));
        }
      } else if (IsTapered(type)) {
        for (const double sign : {1.0, -1.0}) {
          Eigen::Matrix3d turned = axes;
          turned.col(1) *= sign;
          turned.col(2) *= sign;
          GeonState s = Straight(type, turned, ExtentIn(turned, points));
          s.deformation = {0.4, 0.4};
          s.size.head<2>() /= 1.4;
          starts.push_back(s);
        }
      } else {
        starts.push_back(Straight(type, axes, ExtentIn(axes, points)));
      }
    }
  }
  return starts;
}

}  // namespace

std::vector<Eigen::Matrix3d> CandidateFrames(const LanePoints& points) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (int i = 0; i < points.size; ++i) mean += PointAt(points, i) / points.size;
  Eigen::Matrix3d by_point = Eigen::Matrix3d::Zero(), by_normal = Eigen::Matrix3d::Zero();
  for (int i = 0; i < points.size; ++i) {
    const Eigen::Vector3d p = PointAt(points, i) - mean, n = NormalAt(points, i);
    by_point += p * p.transpose();
    by_normal += n * n.transpose();
  }
  const Eigen::Matrix3d points_axes = PrincipalAxes(by_point), normals_axes = PrincipalAxes(by_normal);
  std::pair<Eigen::Matrix3d, double> best{Eigen::Matrix3d::Identity(), -1.0};
  std::vector<Eigen::Matrix3d> starts = {normals_axes, points_axes};
  for (int k = 0; k < 3; ++k) {
    starts.push_back(normals_axes * Eigen::AngleAxisd(0.7854, Eigen::Vector3d::Unit(k)).toRotationMatrix());
  }
  for (const Eigen::Matrix3d& start : starts) {
    const auto climbed = ClimbQuartic(points, start);
    if (climbed.second > best.second * (1.0 + 1e-6)) best = climbed;
  }
  std::vector<Eigen::Matrix3d> frames;
  for (const Eigen::Matrix3d& axes : {best.first, normals_axes, points_axes}) AddFrame(axes, frames);
  return frames;
}

void AddFrame(const Eigen::Matrix3d& axes, std::vector<Eigen::Matrix3d>& frames) {
  if (std::none_of(frames.begin(), frames.end(), [&](const auto& f) { return SameAxes(f, axes); })) frames.push_back(axes);
}

std::vector<GeonState> StartsFromBase(GeonType type, const GeonState& base) {
  std::vector<GeonState> starts;
  const int turns = IsCurved(type) ? 4 : 2;   // bends to four sides; tapers with either end the larger
  for (int axis = 2; axis >= (BaseType(type) == GeonType::kCuboid ? 0 : 2); --axis) {
    for (int turn = 0; turn < turns; ++turn) {
      Eigen::Matrix3d axes;   // of the start in the base's
      axes << Eigen::Vector3d::Unit((axis + 1) % 3), Eigen::Vector3d::Unit((axis + 2) % 3), Eigen::Vector3d::Unit(axis);
      const Eigen::Vector3d about = IsCurved(type) ? Eigen::Vector3d::UnitZ() : Eigen::Vector3d::UnitX();
      axes = axes * Eigen::AngleAxisd(turn * (IsCurved(type) ? kQuarter : 2.0 * kQuarter), about).toRotationMatrix();
      GeonState s = base;
      s.type = type;
      s.rotation = base.rotation * axes;
      s.size = axes.cwiseAbs().transpose() * base.size;
      if (IsTapered(type)) s.deformation = {kLittle, kLittle};
      else s.deformation[0] = kLittle / s.size.z();
      starts.push_back(s);
    }
  }
  return starts;
}

std::vector<GeonState> StartStates(GeonType type, const std::vector<Eigen::Matrix3d>& frames, const LanePoints& all,
                                   const Eigen::Vector3d& view) {
  std::vector<GeonState> starts = StartsInside(type, frames, all);
  if (view.isZero()) return starts;
  // The points and their reflections behind the furthest of them.
  double furthest = 1e300;
  for (int i = 0; i < all.size; ++i) furthest = std::min(furthest, view.dot(PointAt(all, i)));
  LanePoints both(2 * all.size);
  for (int i = 0; i < all.size; ++i) {
    const Eigen::Vector3d p = PointAt(all, i);
    both.Set(2 * i, p, NormalAt(all, i));
    both.Set(2 * i + 1, p - 2.0 * (view.dot(p) - furthest) * view, NormalAt(all, i));
  }
  const std::vector<GeonState> deeper = StartsInside(type, frames, both);
  starts.insert(starts.end(), deeper.begin(), deeper.end());
  return starts;
}

}  // namespace geond
