// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <vector>

#include <Eigen/Geometry>

#include "core/geometry/triangle_mesh.h"
#include "core/surface/remesh.h"
#include "core/surface/signed_grid.h"

namespace geond::test {

// A solid given by a function that is negative inside and grows by about one a metre near the surface.
struct Solid {
  enum class Kind { kEllipsoid, kCylinder, kCuboid, kFrustum, kBentCylinder } kind = Kind::kEllipsoid;
  Eigen::Isometry3d X_TG = Eigen::Isometry3d::Identity();
  Eigen::Vector3d half = Eigen::Vector3d::Ones();  // of the extent along x, y, z
  double top = 1.0;                                // kFrustum: radius at +z over that at -z
  double bend = 0.0;                               // kBentCylinder: total angle, rad

  double Value(const Eigen::Vector3d& p_T) const {
    Eigen::Vector3d p = X_TG.inverse() * p_T;
    if (kind == Kind::kEllipsoid) {
      const Eigen::Vector3d scaled = p.cwiseQuotient(half);
      const double k0 = scaled.norm(), k1 = scaled.cwiseQuotient(half).norm();
      return k1 > 1e-12 ? k0 * (k0 - 1.0) / k1 : -half.minCoeff();
    }
    if (kind == Kind::kCuboid) {
      const Eigen::Vector3d d = p.cwiseAbs() - half;
      return d.cwiseMax(0.0).norm() + std::min(d.maxCoeff(), 0.0);
    }
    double along = p.z(), radius = half.x(), lean = 1.0;
    if (kind == Kind::kBentCylinder && bend > 1e-6) {  // the axis is an arc of radius R in the plane x z
      const double R = 2.0 * half.z() / bend, x = p.x() + R * std::cos(0.5 * bend);
      const double angle = std::atan2(p.z(), x), reach = std::hypot(x, p.z());
      along = R * angle;
      p.x() = reach - R;
    }
    if (kind == Kind::kFrustum) {
      const double slope = half.x() * (top - 1.0) / (2.0 * half.z());
      radius = half.x() + slope * (std::clamp(p.z(), -half.z(), half.z()) + half.z());
      lean = 1.0 / std::hypot(1.0, slope);
    }
    const double dr = (std::hypot(p.x(), p.y()) - radius) * lean, dz = std::abs(along) - half.z();
    return std::hypot(std::max(dr, 0.0), std::max(dz, 0.0)) + std::min(std::max(dr, dz), 0.0);
  }

  Eigen::Vector3d Normal(const Eigen::Vector3d& p) const {
    Eigen::Vector3d g;
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d h = 1e-5 * Eigen::Vector3d::Unit(k);
      g[k] = Value(p + h) - Value(p - h);
    }
    return g.stableNormalized();
  }
};

struct UnionObject {
  std::vector<Solid> solids;
  TriangleMesh mesh;
  std::vector<int> labels;  // a triangle: the solid it lies on
};

inline int NearestSolid(const std::vector<Solid>& solids, const Eigen::Vector3d& p) {
  int best = 0;
  for (int i = 1; i < static_cast<int>(solids.size()); ++i) {
    if (std::abs(solids[i].Value(p)) < std::abs(solids[best].Value(p))) best = i;
  }
  return best;
}

// A random object of `n_parts` solids, each but the first standing on the side or the end of an earlier one, thinner
// than it where they meet, at most 25 degrees off the normal. Tried again until every part shows: at least 60 % of its
// own surface and 4 % of the whole.
inline UnionObject RandomUnion(int n_parts, std::uint64_t seed, int triangles) {
  std::mt19937_64 random(seed);
  const auto uniform = [&](double low, double high) {
    return low + (high - low) * static_cast<double>(random() >> 11) * 0x1p-53;
  };
  const auto unit = [&] {
    const double z = uniform(-1.0, 1.0), a = uniform(0.0, 2.0 * M_PI), r = std::sqrt(1.0 - z * z);
    return Eigen::Vector3d(r * std::cos(a), r * std::sin(a), z);
  };
  for (int attempt = 0; attempt < 200; ++attempt) {
    UnionObject object;
    for (int i = 0; i < n_parts; ++i) {
      Solid solid;
      solid.kind = static_cast<Solid::Kind>(random() % 5);
      const double parent_size = i == 0 ? 1.0 : 0.0;
      Eigen::Vector3d at = Eigen::Vector3d::Zero(), axis = unit();
      double radius = uniform(0.35, 0.8) * parent_size;
      if (i > 0) {
        const Solid& parent = object.solids[random() % object.solids.size()];
        // From inside the parent outward to its surface: near an end or around the side.
        const bool end = random() % 2 == 0;
        Eigen::Vector3d p_G(0.0, 0.0, uniform(-0.5, 0.5) * parent.half.z()), way_G = unit();
        if (end) {
          p_G.setZero();
          way_G = Eigen::Vector3d(0.0, 0.0, random() % 2 == 0 ? 1.0 : -1.0);
        } else {
          way_G.z() = 0.0;
          way_G.normalize();
        }
        const Eigen::Vector3d from = parent.X_TG * p_G, way = parent.X_TG.linear() * way_G;
        double low = 0.0, high = 4.0;
        for (int k = 0; k < 50; ++k) {
          const double middle = 0.5 * (low + high);
          (parent.Value(from + middle * way) < 0.0 ? low : high) = middle;
        }
        at = from + low * way;
        const Eigen::Vector3d normal = parent.Normal(at);
        axis = (normal + std::tan(uniform(0.0, 25.0) * M_PI / 180.0) * unit().cross(normal)).normalized();
        radius = uniform(0.4, 0.75) * std::min(parent.half.x(), parent.half.y());
      }
      const double length = radius * uniform(1.1, 2.6);  // half
      solid.half = {radius, radius * uniform(0.7, 1.0), length};
      if (solid.kind != Solid::Kind::kCuboid && solid.kind != Solid::Kind::kEllipsoid) solid.half.y() = radius;
      solid.top = uniform(0.4, 0.8);
      solid.bend = uniform(0.4, 1.0);
      solid.X_TG.linear() = (Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), axis) *
                             Eigen::AngleAxisd(uniform(0.0, 2.0 * M_PI), Eigen::Vector3d::UnitZ()))
                                .toRotationMatrix();
      solid.X_TG.translation() = at + (length - (i > 0 ? 0.3 * radius : 0.0)) * axis;
      object.solids.push_back(solid);
    }
    const auto value = [&](const Eigen::Vector3d& p) {
      double least = std::numeric_limits<double>::infinity();
      for (const Solid& s : object.solids) least = std::min(least, s.Value(p));
      return least;
    };
    Eigen::AlignedBox3d box;
    for (const Solid& s : object.solids) {
      const double reach = 1.2 * s.half.norm();
      box.extend(s.X_TG.translation() + Eigen::Vector3d::Constant(reach));
      box.extend(s.X_TG.translation() - Eigen::Vector3d::Constant(reach));
    }
    SignedGrid grid(box, box.diagonal().norm() / 110.0, 1.0f);
    for (int k = 0; k < grid.size[2]; ++k) {
      for (int j = 0; j < grid.size[1]; ++j) {
        for (int i = 0; i < grid.size[0]; ++i)
          grid.value[grid.index(i, j, k)] = static_cast<float>(value(grid.node(i, j, k)));
      }
    }
    const TriangleMesh raw = MarchingTetrahedra(grid);
    std::vector<double> shown(object.solids.size(), 0.0);
    double all = 0.0;
    for (int t = 0; t < static_cast<int>(raw.triangles.size()); ++t) {
      const double area = TriangleAreaVector(raw, t).norm();
      shown[NearestSolid(object.solids, TriangleCentroid(raw, t))] += area;
      all += area;
    }
    bool good = Topology(raw).components == 1;
    for (std::size_t i = 0; i < shown.size(); ++i) {
      const Eigen::Vector3d& h = object.solids[i].half;  // about the surface of the box times 0.7
      good =
          good && shown[i] > 0.04 * all && shown[i] > 0.5 * 0.7 * 8.0 * (h.x() * h.y() + h.y() * h.z() + h.z() * h.x());
    }
    if (!good) continue;
    const auto project = [&](const Eigen::Vector3d& p, const Eigen::Vector3d&) {
      Eigen::Vector3d q = p;
      for (int step = 0; step < 3; ++step) {
        const Solid& s = object.solids[NearestSolid(object.solids, q)];
        q -= std::clamp(value(q), -grid.step, grid.step) * s.Normal(q);
      }
      return q;
    };
    RemeshOptions options;
    options.triangles = triangles;
    object.mesh = RemeshOnto(raw, project, options);
    for (int t = 0; t < static_cast<int>(object.mesh.triangles.size()); ++t) {
      object.labels.push_back(NearestSolid(object.solids, TriangleCentroid(object.mesh, t)));
    }
    return object;
  }
  return {};
}

}  // namespace geond::test
