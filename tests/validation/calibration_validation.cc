// SPDX-License-Identifier: Apache-2.0
// Calibration of stations that are wrong, seed by seed: is it accepted, is a box that nobody told it of measured right, and
// are a bent axis, a loose target and a wrong diameter rejected for the right reason?
//   calibration_validation [SEEDS] [DEGREES MM]
#include <cstdio>
#include <cstdlib>
#include <ctime>

#include <Eigen/Eigenvalues>

#include "calib/calibrate.h"
#include "calib/make_view.h"
#include "tests/calib/calibration_scans.h"

namespace geond::calib {
namespace {

constexpr double kDegree = M_PI / 180.0;

// Mean distance of the points that face +-along from the middle plane, over both sides: the size of a box.
struct BoxSizes {
  Eigen::Vector3d error = Eigen::Vector3d::Zero();  // m
};

BoxSizes MeasureBox(const WrongStation& world, const StationCalibration& calibration, std::uint64_t seed) {
  const Eigen::Vector3d low(-0.030, -0.020, 0.0), high(0.030, 0.020, 0.050);
  SyntheticScene scene;
  scene.boxes.push_back({low, high});
  Noise random(seed);
  std::array<std::vector<Eigen::Vector3d>, 6> faces;
  for (int k = 0; k < 8; ++k) {
    Exposure exposure;
    exposure.table_angle = 2.0 * M_PI * k / 8 + 0.2;
    const Pose X_TS = Inverse(world.truth.X_WT * Pose::Rotation(Eigen::Vector3d::UnitZ(), exposure.table_angle)) * world.truth.X_WS;
    exposure.image = TakeImage(scene, world.truth.sensor, X_TS, world.noise, random);
    for (float& depth : exposure.image.depth) depth = static_cast<float>(depth / world.true_scale);
    const RangeView view = MakeView(Corrected(exposure, calibration), calibration.station);
    for (int row = 0; row < view.image.rows; ++row) {
      for (int column = 0; column < view.image.columns; ++column) {
        // Which face it lies on is taken from the truth, so that only the sizes are judged.
        const double depth = view.image.at(column, row);
        if (!view.IsObject(view.image.index(column, row))) continue;
        const Eigen::Vector3d true_T = X_TS * Unproject(world.truth.sensor, column, row, depth);
        for (int axis = 0; axis < 3; ++axis) {
          for (int side = 0; side < 2; ++side) {
            const double plane = side == 0 ? low[axis] : high[axis];
            bool inside = std::abs(true_T[axis] - plane) < 0.004;
            for (int other = 0; other < 3; ++other) {
              if (other != axis) inside = inside && true_T[other] > low[other] + 0.006 && true_T[other] < high[other] - 0.006;
            }
            if (inside) faces[2 * axis + side].push_back(view.X_TS * Unproject(view.sensor, column, row, depth));
          }
        }
      }
    }
  }
  // Two parallel planes through the two sides; the height is taken over the table, z = 0.
  BoxSizes sizes;
  for (int axis = 0; axis < 3; ++axis) {
    Eigen::Vector3d mean[2];
    Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
    for (int side = 0; side < 2; ++side) {
      const auto& points = faces[2 * axis + side];
      mean[side].setZero();
      for (const auto& p : points) mean[side] += p / static_cast<double>(points.size());
      for (const auto& p : points) scatter += (p - mean[side]) * (p - mean[side]).transpose();
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(scatter);
    const Eigen::Vector3d normal = eigen.eigenvectors().col(0);
    const double size = axis == 2 ? mean[1].z() : std::abs(normal.dot(mean[1] - mean[0]));
    sizes.error[axis] = size - (high - low)[axis];
  }
  return sizes;
}

void PrintReasons(const CalibrationResult& result) {
  for (const auto& reason : result.reasons) std::printf("        %s\n", reason.c_str());
}

int Run(int seeds, double turn, double shift) {
  std::printf("axis and sensor wrong by %.1f deg and %.1f mm, depth read 0.5 %% short, noise 0.2 mm\n", turn / kDegree, shift * 1e3);
  std::printf("seed accepted  check sphere  box x, y, height (mm off)   axis (deg)  CPU s\n");
  int accepted = 0, right = 0, bent = 0, loose = 0, diameter = 0;
  double worst_check = 0.0, worst_box = 0.0;
  for (int seed = 1; seed <= seeds; ++seed) {
    const std::clock_t start = std::clock();
    const WrongStation world(turn, shift, static_cast<std::uint64_t>(seed));
    const std::uint64_t noise_seed = 100u + static_cast<std::uint64_t>(seed);
    const auto result = CalibrateStation(world.assumed, world.Target(noise_seed), world.Check(noise_seed));
    const BoxSizes box = MeasureBox(world, result.calibration, noise_seed + 7000);
    const double check = std::abs(result.calibration.check_error), size = box.error.cwiseAbs().maxCoeff();
    const Pose found = Inverse(world.truth.X_WS) * result.calibration.station.X_WT;
    const Pose truth = Inverse(world.truth.X_WS) * world.truth.X_WT;
    const double axis = std::acos(std::min(1.0, found.Rotate(Eigen::Vector3d::UnitZ()).dot(truth.Rotate(Eigen::Vector3d::UnitZ()))));
    accepted += result.accepted;
    right += result.accepted && check <= 1e-4 && size <= 1e-4;
    worst_check = std::max(worst_check, check);
    worst_box = std::max(worst_box, size);
    std::printf("%4d %8s %+13.3f %+9.3f %+8.3f %+8.3f %12.4f %6.1f\n", seed, result.accepted ? "yes" : "NO",
                1e3 * result.calibration.check_error, 1e3 * box.error.x(), 1e3 * box.error.y(), 1e3 * box.error.z(),
                axis / kDegree, static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC);
    if (!result.accepted) PrintReasons(result);
    std::fflush(stdout);
    if (seed % 5 != 1) continue;  // one in five: what must be rejected
    const auto judge = [&](const char* what, const CalibrationResult& wrong, const char* word, int& count) {
      bool said = false;
      for (const auto& reason : wrong.reasons) said = said || reason.find(word) != std::string::npos;
      count += !wrong.accepted && said;
      if (wrong.accepted || !said) std::printf("   %s: %s\n", what, wrong.accepted ? "ACCEPTED" : "rejected, but not for that");
      if (!wrong.accepted && !said) PrintReasons(wrong);
    };
    WrongStation leaning = world;
    leaning.wobble = [&](double angle) {
      return Pose::Rotation(Eigen::Vector3d::UnitX(), 0.006 * std::sin(2.0 * angle + seed)) *
             Pose::Translation({0.0, 0.0005 * std::sin(2.0 * angle + 0.5 * seed), 0.0});
    };
    judge("bent axis", CalibrateStation(world.assumed, leaning.Target(noise_seed), leaning.Check(noise_seed)), "axis is bent", bent);
    WrongStation slipping = world;
    slipping.slip = [&](int image) { return image < 2 + seed % 4 ? Eigen::Vector3d::Zero() : Eigen::Vector3d(0.0007, -0.0006, 0.0); };
    auto target = world.Target(noise_seed);
    target[seed % 3] = seed % 3 == 0   ? slipping.Place({0.045, 0.0}, 0.040, 8, noise_seed)
                       : seed % 3 == 1 ? slipping.Place({-0.015, 0.030}, 0.040, 8, noise_seed, 0.040)
                                       : slipping.Place({0.0, -0.055}, 0.040, 8, noise_seed, 0.015);
    judge("loose target", CalibrateStation(world.assumed, target, world.Check(noise_seed)), "moved by", loose);
    auto misnamed = world.Target(noise_seed);
    for (auto& placement : misnamed) placement.diameter = seed % 2 == 0 ? 0.0404 : 0.0395;
    judge("wrong diameter", CalibrateStation(world.assumed, misnamed, world.Check(noise_seed)), "diameter", diameter);
  }
  const int rejected = (seeds + 4) / 5;
  std::printf("\naccepted %d of %d; check sphere and box right to 0.1 mm %d of %d; worst check %.3f mm, worst box %.3f mm\n", accepted,
              seeds, right, seeds, 1e3 * worst_check, 1e3 * worst_box);
  std::printf("rejected for the right reason: bent axis %d, loose target %d, wrong diameter %d of %d\n", bent, loose, diameter, rejected);
  return 0;
}

}  // namespace
}  // namespace geond::calib

int main(int argc, char** argv) {
  const int seeds = argc > 1 ? std::atoi(argv[1]) : 50;
  const double turn = argc > 2 ? std::atof(argv[2]) : 2.0, shift = argc > 3 ? std::atof(argv[3]) : 5.0;
  return geond::calib::Run(seeds, turn * M_PI / 180.0, shift * 1e-3);
}
