// SPDX-License-Identifier: Apache-2.0
#include "daemon/robot/grasp.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "core/base/printed.h"

namespace geond::daemon {
namespace {

constexpr int kSamples = 1500;          // of a part's surface
constexpr int kTurns = 12;              // directions round an axis
constexpr double kSpread = 0.25;        // cosine: two closing directions nearer than this are one
constexpr std::size_t kMostGrasps = 16;  // a part

// A box of the gripper in H.
struct Box {
  Eigen::Vector3d low, high;
};

// Distance of a point to a box; 0 inside.
double Distance(const Box& box, const Eigen::Vector3d& p) {
  return (box.low - p).cwiseMax(p - box.high).cwiseMax(0.0).norm();
}

// Fingers open to `opening`, and the palm behind them.
std::vector<Box> GripperBoxes(const Gripper& g, double opening) {
  const double half = 0.5 * opening, width = 0.5 * g.finger_width;
  return {{{half, -width, -g.finger_length}, {half + g.finger_thickness, width, 0.0}},
          {{-half - g.finger_thickness, -width, -g.finger_length}, {-half, width, 0.0}},
          {{-0.5 * g.palm_width, -0.25 * g.palm_width, -g.finger_length - 0.03},
           {0.5 * g.palm_width, 0.25 * g.palm_width, -g.finger_length}}};
}

double LowestPoint(const Pose& X_TH, const std::vector<Box>& boxes) {
  double lowest = std::numeric_limits<double>::infinity();
  for (const Box& box : boxes) {
    for (int corner = 0; corner < 8; ++corner) {
      const Eigen::Vector3d p_H(corner & 1 ? box.high.x() : box.low.x(), corner & 2 ? box.high.y() : box.low.y(),
                                corner & 4 ? box.high.z() : box.low.z());
      lowest = std::min(lowest, (X_TH * p_H).z());
    }
  }
  return lowest;
}

// Unit directions along which opposite sides of the shape face each other, in G.
std::vector<Eigen::Vector3d> ClosingDirections(const Geon& geon) {
  std::vector<Eigen::Vector3d> directions = {Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitY(), Eigen::Vector3d::UnitZ()};
  const bool round = BaseType(geon.type) != GeonType::kCuboid && !IsCurved(geon.type) &&
                     std::abs(geon.size.x() - geon.size.y()) < 0.1 * geon.size.x();
  for (int i = 1; round && i < kTurns; ++i) {
    const double angle = std::numbers::pi * i / kTurns;
    if (2 * i != kTurns) directions.emplace_back(std::cos(angle), std::sin(angle), 0.0);
  }
  return directions;
}

// What the fingers touch when they close along x of H at its origin.
struct Contact {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  double facing = 0.0;  // mean |normal . x| at the two sides
  bool both = false;
};

Contact FindContact(const PointCloud& surface_T, const Pose& X_TH, const Gripper& g) {
  const Pose X_HT = Inverse(X_TH);
  std::vector<std::pair<double, double>> touched;  // x and normal along x
  Contact contact;
  for (std::size_t i = 0; i < surface_T.size(); ++i) {
    const Eigen::Vector3d p = X_HT * surface_T.points[i];
    if (std::abs(p.y()) > 0.5 * g.finger_width || p.z() > 0.0 || p.z() < -2.0 * g.reach) continue;
    contact.low = std::min(contact.low, p.x());
    contact.high = std::max(contact.high, p.x());
    touched.emplace_back(p.x(), X_HT.Rotate(surface_T.normals[i]).x());
  }
  double facing[2] = {0.0, 0.0};
  int count[2] = {0, 0};
  const double depth = std::max(0.002, 0.1 * (contact.high - contact.low));
  for (const auto& [x, normal] : touched) {
    if (x < contact.low + depth) facing[0] += -normal, ++count[0];
    if (x > contact.high - depth) facing[1] += normal, ++count[1];
  }
  contact.both = count[0] > 0 && count[1] > 0 && contact.high - contact.low > 1e-4;
  if (contact.both) contact.facing = std::clamp(std::min(facing[0] / count[0], facing[1] / count[1]), 0.0, 1.0);
  return contact;
}

std::string Reason(const Geon& geon, const Grasp& grasp) {
  const double down = -grasp.X_TH.matrix().col(2).z();
  const char* from = down > 0.85 ? "from above" : down > 0.3 ? "from obliquely above" : "from the side";
  return Printed("%s of %.0f mm between the fingers, %s, %.0f mm clear",
                 std::string(GeonTypeName(geon.type)).c_str(), 1e3 * grasp.opening, from, 1e3 * grasp.clearance);
}

}  // namespace

std::vector<Grasp> FindGrasps(const std::vector<Geon>& parts, int part, const Gripper& g) {
  if (part < 0 || part >= static_cast<int>(parts.size())) throw std::invalid_argument("FindGrasps: there is no such part");
  const Geon& geon = parts[part];
  const PointCloud own = SampleGeon(geon, kSamples);
  std::vector<Eigen::Vector3d> others;
  for (int i = 0; i < static_cast<int>(parts.size()); ++i) {
    if (i == part) continue;
    const PointCloud cloud = SampleGeon(parts[i], kSamples);
    others.insert(others.end(), cloud.points.begin(), cloud.points.end());
  }

  std::vector<Grasp> grasps;
  for (const double share : {0.0, 0.35, -0.35, 0.65, -0.65}) {
    const Eigen::Vector3d middle = geon.X_TG * Eigen::Vector3d(0, 0, share * geon.size.z());
    for (const Eigen::Vector3d& direction_G : ClosingDirections(geon)) {
      if (share != 0.0 && direction_G.z() != 0.0) continue;
      const Eigen::Vector3d x = geon.X_TG.Rotate(direction_G);
      const Eigen::Vector3d u = x.unitOrthogonal(), v = x.cross(u);
      for (int turn = 0; turn < kTurns; ++turn) {
        const double angle = 2.0 * std::numbers::pi * turn / kTurns;
        const Eigen::Vector3d z = std::cos(angle) * u + std::sin(angle) * v;
        if (z.z() > 0.1) continue;  // from below
        Eigen::Matrix3d rotation;
        rotation << x, z.cross(x), z;
        Pose X_TH(rotation, middle + g.reach * z);
        const Contact contact = FindContact(own, X_TH, g);
        const double width = contact.high - contact.low;
        if (!contact.both || contact.facing < 0.5 || width + 2.0 * g.clearance > g.max_opening) continue;
        X_TH = X_TH * Pose::Translation({0.5 * (contact.low + contact.high), 0, 0});

        const std::vector<Box> boxes = GripperBoxes(g, width + 2.0 * g.clearance);
        const Pose X_HT = Inverse(X_TH);
        double clearance = LowestPoint(X_TH, boxes);
        for (const Eigen::Vector3d& p : others) {
          for (const Box& box : boxes) clearance = std::min(clearance, Distance(box, X_HT * p));
          if (clearance < g.clearance) break;
        }
        if (clearance < g.clearance) continue;
        const bool blocked = std::any_of(own.points.begin(), own.points.end(), [&](const Eigen::Vector3d& p) {
          return std::any_of(boxes.begin(), boxes.end(), [&](const Box& box) { return Distance(box, X_HT * p) <= 0.0; });
        });
        if (blocked) continue;

        Grasp grasp;
        grasp.part = part;
        grasp.X_TH = X_TH;
        grasp.opening = width;
        grasp.clearance = clearance;
        grasp.quality = 0.4 * contact.facing + 0.25 * (1.0 - std::abs(share)) + 0.2 * std::min(1.0, clearance / 0.03) +
                        0.15 * std::max(0.0, -z.z());
        grasp.reason = Reason(geon, grasp);
        grasps.push_back(std::move(grasp));
      }
    }
  }
  std::stable_sort(grasps.begin(), grasps.end(), [](const Grasp& a, const Grasp& b) { return a.quality > b.quality; });
  // Of grasps that are nearly the same the best is enough.
  std::vector<Grasp> distinct;
  for (const Grasp& grasp : grasps) {
    const bool known = std::any_of(distinct.begin(), distinct.end(), [&](const Grasp& other) {
      const Eigen::Matrix3d turn = other.X_TH.matrix().transpose() * grasp.X_TH.matrix();
      return (other.X_TH.translation() - grasp.X_TH.translation()).norm() < 0.01 && turn(2, 2) > 1.0 - kSpread &&
             std::abs(turn(0, 0)) > 1.0 - kSpread;
    });
    if (!known && distinct.size() < kMostGrasps) distinct.push_back(grasp);
  }
  return distinct;
}

}  // namespace geond::daemon
