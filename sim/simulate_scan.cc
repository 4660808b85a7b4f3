// SPDX-License-Identifier: Apache-2.0
#include "sim/simulate_scan.h"

#include <algorithm>
#include <numbers>
#include <stdexcept>

#include "sim/random.h"

namespace geond::sim {
namespace {

constexpr std::uint64_t kPoseStream = 0x706f736500000000u;
constexpr double kUsualField = 0.260;  // m

Eigen::Vector3d RandomVector(CounterRandom& random, double deviation) {
  const double x = random.Normal(), y = random.Normal(), z = random.Normal();
  return deviation * Eigen::Vector3d(x, y, z);
}

// A rotation by a vector: its direction is the axis, its length the angle.
Pose SmallMotion(const Eigen::Vector3d& rotation, const Eigen::Vector3d& translation) {
  const double angle = rotation.norm();
  const Pose turn = angle > 0.0 ? Pose::Rotation(rotation / angle, angle) : Pose();
  return Pose::Translation(translation) * turn;
}

}  // namespace

RecordedScan SimulateScan(const Scene& scene, const SimOptions& options, std::stop_token stop,
                          const StepObserver& on_step) {
  if (options.views < 1 || options.views > 360) throw std::invalid_argument("SimulateScan: 1 to 360 views");
  const SceneGeometry geometry(scene);
  const Eigen::AlignedBox3d& box = geometry.box();
  // Half the field must hold the object's far corner wherever the table has turned it.
  const double middle = 0.5 * (box.min().z() + box.max().z());
  double reach = 0.0;
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3d p = box.corner(static_cast<Eigen::AlignedBox3d::CornerType>(corner));
    reach = std::max(reach, (p - Eigen::Vector3d(0.0, 0.0, middle)).norm());
  }
  if (!(options.distance > 1.2 * reach)) {
    throw std::invalid_argument("SimulateScan: the object reaches too near to the sensor; take a greater distance");
  }
  const double needed = 2.1 * reach * options.distance / (options.distance - 0.7 * reach);
  const double field = options.field > 0.0 ? options.field : std::max(kUsualField, needed);

  RecordedScan scan;
  scan.station = MakeStation(options.distance, options.elevation, middle, options.columns, options.rows, field,
                             options.depth_noise);
  scan.seed = options.seed;
  scan.software = "geond " GEOND_VERSION;
  scan.truth = TruthJson(scene);
  StationGeometry truth = scan.station;
  truth.X_WT = scan.station.X_WT * AxisErrorPose(options.axis_error);
  for (int i = 0; i < options.views; ++i) {
    ThrowIfStopped(stop);
    if (on_step) on_step("simulate", i, options.views);
    const double angle = options.first_angle + 2.0 * std::numbers::pi * i / options.views;
    CounterRandom random(options.seed, kPoseStream, static_cast<std::uint64_t>(i));
    const double true_angle = angle + options.angle_noise * random.Normal();
    const Eigen::Vector3d rotation = RandomVector(random, options.view_rotation);
    const Eigen::Vector3d translation = RandomVector(random, options.view_translation);
    RecordedScan::View view;
    view.sensor = scan.station.sensor;
    view.X_TS_measured = SmallMotion(rotation, translation) * SensorInTurntable(scan.station, angle);
    view.exposure.table_angle = angle;
    view.exposure.timestamp = std::chrono::seconds(i);
    view.exposure.image = TakeRangeImage(geometry, view.sensor, SensorInTurntable(truth, true_angle), options.camera,
                                         options.seed, static_cast<std::uint64_t>(i), options.threads);
    scan.views.push_back(std::move(view));
  }
  if (on_step) on_step("simulate", options.views, options.views);
  return scan;
}

}  // namespace geond::sim
