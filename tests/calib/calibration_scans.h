// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <vector>

#include "calib/calibrate.h"
#include "calib/pose_model.h"
#include "tests/calib/synthetic_scan.h"

namespace geond::calib {

// A station whose calibration is wrong, and what it sees of spheres: the world against which calibration is judged.
struct WrongStation {
  StationGeometry truth = SyntheticStation(200, 0.20);
  StationGeometry assumed;
  double true_scale = 1.005;     // read depth times this is the true one
  double noise = 0.0002;         // m along the ray
  std::function<Pose(double angle)> wobble;              // further motion of the table in W at an angle, or none
  std::function<Eigen::Vector3d(int image)> slip;        // shift of the target in T before an image, or none

  // Axis wrong by so much (rad about horizontal directions, m), drawn from a seed.
  WrongStation(double turn, double shift, std::uint64_t seed) {
    Noise random(seed);
    assumed = truth;
    const double a = 2.0 * M_PI * random.Uniform();
    Eigen::Matrix<double, 6, 1> off;
    off << turn * std::cos(a), turn * std::sin(a), 0.0, shift * random.Vector().normalized();
    assumed.X_WT = Moved(truth.X_WT, off, Eigen::Vector3d::Zero(), 1.0);
  }

  TargetPlacement Place(const Eigen::Vector2d& at, double diameter, int images, std::uint64_t seed,
                        double lift = 0.0) const {
    Noise random(seed);
    TargetPlacement placement;
    placement.diameter = diameter;
    for (int k = 0; k < images; ++k) {
      Exposure exposure;
      exposure.table_angle = 2.0 * M_PI * k / images;
      Pose X_WT = truth.X_WT * Pose::Rotation(Eigen::Vector3d::UnitZ(), exposure.table_angle);
      if (wobble) X_WT = wobble(exposure.table_angle) * X_WT;
      SyntheticScene scene;
      Eigen::Vector3d center(at.x(), at.y(), 0.5 * diameter + lift);
      if (slip) center += slip(k);
      scene.spheres.push_back({center, 0.5 * diameter});
      exposure.image = TakeImage(scene, truth.sensor, Inverse(X_WT) * truth.X_WS, noise, random);
      for (float& depth : exposure.image.depth) depth = static_cast<float>(depth / true_scale);
      placement.exposures.push_back(std::move(exposure));
    }
    return placement;
  }

  std::vector<TargetPlacement> Target(std::uint64_t seed, int images = 8, double diameter = 0.040) const {
    return {Place({0.045, 0.0}, diameter, images, seed), Place({-0.015, 0.030}, diameter, images, seed + 1000, 0.040),
            Place({0.0, -0.055}, diameter, images, seed + 2000, 0.015)};
  }
  std::vector<TargetPlacement> Check(std::uint64_t seed, double diameter = 0.060) const {
    return {Place({0.005, 0.010}, diameter, 6, seed + 3000)};
  }
};

}  // namespace geond::calib
