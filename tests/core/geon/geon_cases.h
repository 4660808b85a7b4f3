// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <nlohmann/json.hpp>

#include "core/geon/geon.h"
#include "core/geometry/point_cloud.h"

namespace geond {

inline nlohmann::json ReadJson(const std::string& path) {
  std::ifstream file(path);
  if (!file) throw std::runtime_error(path + ": cannot be read");
  return nlohmann::json::parse(file);
}

// The parameter lists of the case files: ax ay az tx ty tz rx ry rz [kx ky | kappa], rotation Rz Ry Rx.
inline Geon GeonOfCase(int type, const std::vector<double>& p) {
  Geon geon;
  geon.type = static_cast<GeonType>(type);
  geon.size = {p.at(0), p.at(1), p.at(2)};
  const Eigen::Matrix3d rotation = (Eigen::AngleAxisd(p.at(8), Eigen::Vector3d::UnitZ()) *
                                    Eigen::AngleAxisd(p.at(7), Eigen::Vector3d::UnitY()) *
                                    Eigen::AngleAxisd(p.at(6), Eigen::Vector3d::UnitX()))
                                       .toRotationMatrix();
  geon.X_TG = Pose(rotation, Eigen::Vector3d(p.at(3), p.at(4), p.at(5)));
  if (IsTapered(geon.type)) geon.taper = {p.at(9), p.at(10)};
  if (IsCurved(geon.type)) geon.bend = p.at(9);
  return geon;
}

inline PointCloud CloudOfCase(const nlohmann::json& item) {
  PointCloud cloud;
  for (const auto& p : item.at("points")) cloud.points.emplace_back(p[0], p[1], p[2]);
  for (const auto& n : item.at("normals")) cloud.normals.emplace_back(n[0], n[1], n[2]);
  return cloud;
}

}  // namespace geond
