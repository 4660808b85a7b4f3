// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <nlohmann/json.hpp>

#include "calib/depth_jumps.h"
#include "core/range/range_view.h"

namespace geond::calib {

// Views of an object on a turntable with known poses, and starts that are wrong in two ways.
struct RegistrationCase {
  std::vector<RangeView> views;      // with the true poses, table angles as geond counts them
  std::vector<Pose> X_TS_true;
  std::vector<Pose> X_TS_axis;       // from an axis wrong by 0.3 degree and 0.5 mm
  std::vector<Pose> X_TS_perturbed;  // and every view by 1 degree and 1 mm more
};

inline Pose PoseFromJson(const nlohmann::json& rows) {
  Eigen::Matrix3d rotation;
  Eigen::Vector3d translation;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) rotation(r, c) = rows[r][c].get<double>();
    translation[r] = rows[r][3].get<double>() * 1e-3;
  }
  return Pose(rotation, translation);
}

inline std::vector<char> FileBytes(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw std::runtime_error("cannot read " + path.string());
  return {std::istreambuf_iterator<char>(file), {}};
}

// Ranges along normalised rays ((u0 + c pitch), (v0 + r pitch), 1), mm, as depths in m; status 1 object, 2 grazing, 3 table.
inline RangeView ViewFromRanges(const std::filesystem::path& ranges, const std::filesystem::path& status, double noise) {
  const auto bytes = FileBytes(ranges), states = FileBytes(status);
  const auto at = [&]<typename T>(T, std::size_t offset) {
    T value;
    std::memcpy(&value, bytes.data() + offset, sizeof value);
    return value;
  };
  RangeView view;
  view.image.rows = at(std::int32_t{}, 0);
  view.image.columns = at(std::int32_t{}, 4);
  const double u0 = at(0.0f, 8), v0 = at(0.0f, 12), pitch = at(0.0f, 16);
  view.sensor.columns = view.image.columns;
  view.sensor.rows = view.image.rows;
  view.sensor.focal_u = view.sensor.focal_v = 1.0 / pitch;
  view.sensor.center_u = -u0 / pitch;
  view.sensor.center_v = -v0 / pitch;
  view.sensor.depth_noise = noise;
  for (int r = 0; r < view.image.rows; ++r) {
    for (int c = 0; c < view.image.columns; ++c) {
      const std::size_t i = view.image.index(c, r);
      const double range = at(0.0f, 20 + 4 * i) * 1e-3, u = u0 + c * pitch, v = v0 + r * pitch;
      const bool has = range > 0.0;
      view.image.depth.push_back(has ? static_cast<float>(range / std::sqrt(1 + u * u + v * v)) : std::nanf(""));
      const char state = states[i];
      view.classes.push_back(!has || state == 0 || state == 2 ? PixelClass::kNothing
                             : state == 1                     ? PixelClass::kObject
                                                              : PixelClass::kTable);
    }
  }
  return view;
}

inline RegistrationCase ReadRegistrationCase(const std::filesystem::path& folder) {
  const auto json = nlohmann::json::parse(std::ifstream(folder / "case.json"));
  RegistrationCase read;
  // T turns about the axis that the station assumes: the poses of the wrong axis are given in the true T, where that axis
  // is oblique, so they are taken to the frame whose z it is.
  Eigen::Vector3d point, direction;
  for (int k = 0; k < 3; ++k) {
    point[k] = json["assumed_axis_point"][k].get<double>() * 1e-3;
    direction[k] = json["assumed_axis_dir"][k].get<double>();
  }
  const Pose X_TA(Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), direction), point);
  for (const auto& item : json["views"]) {
    RangeView view = ViewFromRanges(folder / item["range"].get<std::string>(),
                                    folder / item["status"].get<std::string>(), json["noise_sigma"].get<double>() * 1e-3);
    view.table_angle = -item["turntable_angle_deg"].get<double>() * M_PI / 180.0;  // there the sensor goes round
    view.X_TS = view.X_TS_measured = PoseFromJson(item["pose_true"]);
    read.X_TS_true.push_back(view.X_TS);
    read.X_TS_axis.push_back(Inverse(X_TA) * PoseFromJson(item["pose_axis"]));
    read.X_TS_perturbed.push_back(Inverse(X_TA) * PoseFromJson(item["pose_perturbed"]));
    RejectMixedPixels(view, 1.45);
    read.views.push_back(EstimateNormals(std::move(view)));
  }
  return read;
}

inline std::vector<RangeView> StartingAt(std::vector<RangeView> views, const std::vector<Pose>& X_TS) {
  for (std::size_t k = 0; k < views.size(); ++k) views[k].X_TS = views[k].X_TS_measured = X_TS[k];
  return views;
}

// Errors of a set of poses against the truth after the best common rigid motion of all points, m.
struct PoseSetError {
  double displacement_rms = 0.0;
  double normal_rms = 0.0;       // along the surface normals, after that motion
  double shape_rms = 0.0;        // along the surface normals, after the motion that makes this least: how far the surfaces lie
                                 // apart, whatever was turned that the shape does not show
};

inline PoseSetError ComparePoses(const std::vector<RangeView>& views, const std::vector<Pose>& found,
                                 const std::vector<Pose>& truth) {
  std::vector<Eigen::Vector3d> p, q, n;
  for (std::size_t k = 0; k < views.size(); ++k) {
    const PointCloud cloud_S = ViewCloud(views[k]);
    for (std::size_t i = 0; i < cloud_S.size(); ++i) {
      p.push_back(found[k] * cloud_S.points[i]);
      q.push_back(truth[k] * cloud_S.points[i]);
      n.push_back(truth[k].Rotate(cloud_S.normals[i]));
    }
  }
  Eigen::Matrix3Xd P(3, p.size()), Q(3, q.size());
  for (std::size_t i = 0; i < p.size(); ++i) {
    P.col(static_cast<Eigen::Index>(i)) = p[i];
    Q.col(static_cast<Eigen::Index>(i)) = q[i];
  }
  const Eigen::Matrix4d align = Eigen::umeyama(P, Q, false);
  PoseSetError error;
  for (std::size_t i = 0; i < p.size(); ++i) {
    const Eigen::Vector3d d = align.topLeftCorner<3, 3>() * p[i] + align.topRightCorner<3, 1>() - q[i];
    error.displacement_rms += d.squaredNorm() / static_cast<double>(p.size());
    error.normal_rms += std::pow(d.dot(n[i]), 2) / static_cast<double>(p.size());
  }
  Eigen::Matrix<double, 6, 6> A = Eigen::Matrix<double, 6, 6>::Identity() * 1e-12;
  Eigen::Matrix<double, 6, 1> g = Eigen::Matrix<double, 6, 1>::Zero();
  const Eigen::Vector3d middle = Q.rowwise().mean();
  const auto row = [&](std::size_t i) {
    Eigen::Matrix<double, 6, 1> j;
    j << (q[i] - middle).cross(n[i]), n[i];
    return j;
  };
  for (std::size_t i = 0; i < p.size(); ++i) A += row(i) * row(i).transpose(), g += row(i) * n[i].dot(p[i] - q[i]);
  const Eigen::Matrix<double, 6, 1> motion = A.ldlt().solve(g);
  for (std::size_t i = 0; i < p.size(); ++i) {
    error.shape_rms += std::pow(n[i].dot(p[i] - q[i]) - row(i).dot(motion), 2) / static_cast<double>(p.size());
  }
  error.shape_rms = std::sqrt(error.shape_rms);
  error.displacement_rms = std::sqrt(error.displacement_rms);
  error.normal_rms = std::sqrt(error.normal_rms);
  return error;
}

}  // namespace geond::calib
