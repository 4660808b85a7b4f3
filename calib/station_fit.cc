// SPDX-License-Identifier: Apache-2.0
#include "calib/station_fit.h"

#include <algorithm>
#include <cmath>

#include <ceres/ceres.h>

namespace geond::calib {
namespace {

constexpr double kNoise = 0.0002;       // m, weight of a return where the sensor's noise is not known
constexpr double kPlatePrior = 0.0087;  // slope of the table top against the axis

template <typename T>
Eigen::Matrix<T, 3, 1> PointOf(const SensorModel& sensor, const T* correction, const RawReturn& raw) {
  const T z = T(raw.depth) * (T(1.0) + correction[0]) + correction[1];
  const T scale = sensor.projection == SensorModel::Projection::kPerspective ? z : T(1.0);
  return {T((raw.column - sensor.center_u) / sensor.focal_u) * scale / (T(1.0) + correction[2]),
          T((raw.row - sensor.center_v) / sensor.focal_v) * scale / (T(1.0) + correction[3]), z};
}

// p_T of a return at a table angle.
template <typename T>
Eigen::Matrix<T, 3, 1> InTable(const Eigen::Matrix<T, 3, 1>& p_S, const T* rotation, const T* translation,
                               double angle) {
  const Eigen::Map<const Eigen::Quaternion<T>> R_ST(rotation);
  const Eigen::Map<const Eigen::Matrix<T, 3, 1>> t_ST(translation);
  const Eigen::Matrix<T, 3, 1> p = R_ST.conjugate() * (p_S - t_ST);
  const double c = std::cos(angle), s = std::sin(angle);
  return {T(c) * p.x() + T(s) * p.y(), T(-s) * p.x() + T(c) * p.y(), p.z()};
}

// The depth at which the ray meets the sphere less the depth read, over the noise of reading it. In the sensor's own scale: in
// the corrected one a smaller scale would make the noise smaller, and least squares would choose it (0.2 % too small at a noise
// of 0.2 mm). And along the ray: the distance from the sphere changes with the unknowns by an amount that shares its noise.
struct SphereReturn {
  const SensorModel& sensor;
  RawReturn raw;
  double angle, radius, noise;  // noise: along the ray
  template <typename T>
  bool operator()(const T* correction, const T* rotation, const T* translation, const T* center, T* residual) const {
    const Eigen::Map<const Eigen::Quaternion<T>> R_ST(rotation);
    const Eigen::Map<const Eigen::Matrix<T, 3, 1>> t_ST(translation), center_T(center);
    const double c = std::cos(angle), s = std::sin(angle);
    const Eigen::Matrix<T, 3, 1> turned(T(c) * center_T.x() - T(s) * center_T.y(), T(s) * center_T.x() + T(c) * center_T.y(),
                                        center_T.z());
    const Eigen::Matrix<T, 3, 1> center_S = R_ST * turned + t_ST;
    const Eigen::Matrix<T, 3, 1> p = PointOf(sensor, correction, raw);
    const bool perspective = sensor.projection == SensorModel::Projection::kPerspective;
    const Eigen::Matrix<T, 3, 1> ray =
        perspective ? Eigen::Matrix<T, 3, 1>(p.normalized()) : Eigen::Matrix<T, 3, 1>(T(0.0), T(0.0), T(1.0));
    const Eigen::Matrix<T, 3, 1> arm = center_S - p;  // its part along the ray is how far behind the return the centre lies
    const T along = arm.dot(ray);
    const T half_chord = radius * radius - (arm.squaredNorm() - along * along);
    // A ray that passes the sphere by while the solve goes on is taken as touching it.
    const T least(1e-4 * radius * radius);
    residual[0] = (sqrt(half_chord > least ? half_chord : least) - along) / (T(noise) * (T(1.0) + correction[0]));
    return true;
  }
};

// Cosine of ray and normal where a return's ray meets a sphere.
double CosineOnSphere(const SensorModel& sensor, const RawReturn& raw, const Eigen::Vector3d& center_S, double radius) {
  const Eigen::Vector3d ray = RayDirection(sensor, raw.column, raw.row);
  const Eigen::Vector3d arm = center_S - Unproject(sensor, raw.column, raw.row, raw.depth);
  const double off = (arm - ray * ray.dot(arm)).norm() / radius;
  return std::sqrt(std::max(0.04, 1.0 - off * off));
}

struct TableReturn {
  const SensorModel& sensor;
  RawReturn raw;
  double angle, noise;
  template <typename T>
  bool operator()(const T* correction, const T* rotation, const T* translation, const T* plate, T* residual) const {
    const auto p_T = InTable<T>(PointOf(sensor, correction, raw), rotation, translation, angle);
    residual[0] = (p_T.z() - plate[0] * p_T.x() - plate[1] * p_T.y()) / (T(noise) * (T(1.0) + correction[0]));
    return true;
  }
};

struct Prior {
  std::vector<double> mean, sigma;
  template <typename T>
  bool operator()(const T* x, T* residual) const {
    for (std::size_t k = 0; k < mean.size(); ++k) residual[k] = (x[k] - T(mean[k])) / T(sigma[k]);
    return true;
  }
};

template <int kSize>
void AddPrior(ceres::Problem& problem, double* block, std::vector<double> mean, std::vector<double> sigma) {
  problem.AddResidualBlock(
      new ceres::AutoDiffCostFunction<Prior, kSize, kSize>(new Prior{std::move(mean), std::move(sigma)}), nullptr, block);
}

// The turn about z is where angle 0 is: no measurement shows it, so it is held at the assumed one.
struct AngleZero {
  Eigen::Quaterniond assumed;
  template <typename T>
  bool operator()(const T* rotation, T* residual) const {
    const Eigen::Map<const Eigen::Quaternion<T>> R(rotation);
    residual[0] = T(2e4) * (assumed.conjugate().cast<T>() * R).z();
    return true;
  }
};

void SetCovariance(ceres::Problem& problem, const SensorModel& sensor, double* rotation, double* translation,
                   double* correction, StationFit& fit) {
  ceres::Covariance::Options options;
  options.algorithm_type = ceres::DENSE_SVD;
  options.null_space_rank = 0;
  options.num_threads = 1;
  ceres::Covariance covariance(options);
  if (!covariance.Compute({{rotation, rotation}, {translation, translation}, {translation, correction},
                           {correction, correction}}, &problem)) {
    return;
  }
  using Rows3x4 = Eigen::Matrix<double, 3, 4, Eigen::RowMajor>;
  Eigen::Matrix<double, 3, 3, Eigen::RowMajor> of_rotation, of_translation;
  Eigen::Matrix<double, 4, 4, Eigen::RowMajor> of_sensor;
  Rows3x4 of_both;
  covariance.GetCovarianceBlockInTangentSpace(rotation, rotation, of_rotation.data());
  covariance.GetCovarianceBlock(translation, translation, of_translation.data());
  covariance.GetCovarianceBlock(translation, correction, of_both.data());
  covariance.GetCovarianceBlock(correction, correction, of_sensor.data());
  // The manifold's tangent counts half angles, in the frame on the left (S): across the axis counts.
  const Eigen::Vector3d axis_S = fit.X_ST.Rotate(Eigen::Vector3d::UnitZ());
  const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - axis_S * axis_S.transpose();
  fit.axis_direction_sigma = 2.0 * std::sqrt(std::max(0.0, (across * of_rotation * across).trace()));
  // What counts is where the axis stands among the points that the sensor measures there: errors of the depth offset
  // move both.
  const Eigen::Vector3d t(translation[0], translation[1], translation[2]);
  const bool perspective = sensor.projection == SensorModel::Projection::kPerspective;
  const Eigen::Vector3d along = perspective ? Eigen::Vector3d(t / t.z()) : Eigen::Vector3d::UnitZ();
  Rows3x4 moves = Rows3x4::Zero();
  moves.col(0) = along * t.z();
  moves.col(1) = along;
  moves(0, 2) = -t.x();
  moves(1, 3) = -t.y();
  const Eigen::Matrix3d mixed = of_both * moves.transpose();
  const Eigen::Matrix3d relative = of_translation - mixed - mixed.transpose() + moves * of_sensor * moves.transpose();
  fit.axis_position_sigma = std::sqrt(std::max(0.0, (across * relative * across).trace()));
  fit.scale_sigma = std::sqrt(std::max(0.0, of_sensor(0, 0)));
  fit.known = true;
}

}  // namespace

Eigen::Vector3d CorrectedPoint(const SensorModel& sensor, const std::array<double, 4>& correction, const RawReturn& raw) {
  return PointOf(sensor, correction.data(), raw);
}

StationFit SolveStation(const SensorModel& sensor, const Pose& X_ST, const std::vector<SightedPlacement>& placements,
                        const CalibrateOptions& options) {
  StationFit fit;
  const double noise = sensor.depth_noise > 0 ? sensor.depth_noise : kNoise;
  Eigen::Quaterniond rotation = X_ST.rotation();
  Eigen::Vector3d translation = X_ST.translation();
  for (const auto& placement : placements) {
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (const auto& sighting : placement.sightings) {
      mean += InTable<double>(sighting.center_S, rotation.coeffs().data(), translation.data(), sighting.table_angle);
    }
    fit.centers_T.push_back(mean / static_cast<double>(placement.sightings.size()));
  }

  ceres::Problem problem;
  double* q = rotation.coeffs().data();
  double* t = translation.data();
  problem.AddParameterBlock(q, 4, new ceres::EigenQuaternionManifold);
  problem.AddParameterBlock(t, 3);
  problem.AddParameterBlock(fit.sensor.data(), 4);
  problem.AddParameterBlock(fit.plate.data(), 2);
  bool table_seen = false;
  auto* loss = new ceres::CauchyLoss(3.0);  // the problem owns it
  for (std::size_t k = 0; k < placements.size(); ++k) {
    for (const auto& sighting : placements[k].sightings) {
      for (const auto& raw : sighting.sphere) {
        // Noise along the ray grows with the incidence; as it is at the start, so that no unknown can gain by it.
        const double along_ray = noise / CosineOnSphere(sensor, raw, sighting.center_S, placements[k].radius);
        problem.AddResidualBlock(
            new ceres::AutoDiffCostFunction<SphereReturn, 1, 4, 4, 3, 3>(
                new SphereReturn{sensor, raw, sighting.table_angle, placements[k].radius, along_ray}),
            loss, fit.sensor.data(), q, t, fit.centers_T[k].data());
      }
      for (std::size_t i = 0; i < sighting.table.size(); i += 3) {
        table_seen = true;
        problem.AddResidualBlock(new ceres::AutoDiffCostFunction<TableReturn, 1, 4, 4, 3, 2>(
                                     new TableReturn{sensor, sighting.table[i], sighting.table_angle, noise}),
                                 loss, fit.sensor.data(), q, t, fit.plate.data());
      }
    }
  }
  AddPrior<4>(problem, fit.sensor.data(), {0, 0, 0, 0},
              {options.prior_scale, options.prior_offset, options.prior_scale, options.prior_scale});
  AddPrior<2>(problem, fit.plate.data(), {0, 0}, {kPlatePrior, kPlatePrior});
  problem.AddResidualBlock(new ceres::AutoDiffCostFunction<AngleZero, 1, 4>(new AngleZero{X_ST.rotation()}), nullptr, q);
  // Without returns of the table its height is what was assumed.
  const double loose = 0.05, height = table_seen ? loose : 1e-4;
  AddPrior<3>(problem, t, {X_ST.translation().x(), X_ST.translation().y(), X_ST.translation().z()},
              {height, height, height});

  ceres::Solver::Options solver;
  solver.linear_solver_type = ceres::DENSE_NORMAL_CHOLESKY;
  solver.max_num_iterations = 60;
  solver.function_tolerance = 1e-12;
  solver.parameter_tolerance = 1e-10;
  solver.num_threads = 1;
  solver.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &problem, &summary);
  fit.summary.converged = summary.termination_type == ceres::CONVERGENCE;
  fit.summary.iterations = static_cast<int>(summary.iterations.size());
  fit.summary.message = summary.message;
  fit.summary.seconds = summary.total_time_in_seconds;
  fit.summary.residual = summary.initial_cost > 0 ? summary.final_cost / summary.initial_cost : 0.0;
  fit.X_ST = Pose(rotation, translation);
  SetCovariance(problem, sensor, q, t, fit.sensor.data(), fit);

  std::vector<double> off;
  for (std::size_t k = 0; k < placements.size(); ++k) {
    for (const auto& sighting : placements[k].sightings) {
      for (const auto& raw : sighting.sphere) {
        const auto p_T = InTable<double>(PointOf(sensor, fit.sensor.data(), raw), q, t, sighting.table_angle);
        off.push_back(std::abs((p_T - fit.centers_T[k]).norm() - placements[k].radius));
      }
    }
  }
  if (!off.empty()) {
    const auto middle = off.begin() + static_cast<std::ptrdiff_t>(off.size() / 2);
    std::nth_element(off.begin(), middle, off.end());
    fit.rms = 1.4826 * *middle;
  }
  return fit;
}

}  // namespace geond::calib
