// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <map>
#include <numbers>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <nlohmann/json.hpp>

#include "core/charge/charge_density.h"
#include "core/geometry/triangle_mesh.h"

namespace geond::test {

// A mesh with its true parts and its charge, as the reference cases have them.
struct SegmentationCase {
  TriangleMesh mesh;
  ChargeDensity charge;
  std::vector<int> labels;
  int n_parts = 0;
};

inline TriangleMesh ReadOff(const std::filesystem::path& path) {
  std::ifstream in(path);
  std::string magic;
  int n_vertices = 0, n_faces = 0, n_edges = 0;
  if (!(in >> magic >> n_vertices >> n_faces >> n_edges) || magic != "OFF")
    throw std::runtime_error("no OFF: " + path.string());
  TriangleMesh mesh;
  mesh.vertices.resize(n_vertices);
  mesh.triangles.resize(n_faces);
  for (auto& v : mesh.vertices) in >> v.x() >> v.y() >> v.z();
  for (auto& t : mesh.triangles) {
    int corners = 0;
    in >> corners >> t[0] >> t[1] >> t[2];
    if (corners != 3) throw std::runtime_error("no triangle: " + path.string());
  }
  if (!in) throw std::runtime_error("cut short: " + path.string());
  return mesh;
}

// Reads `<folder>/<name>.json` and the mesh it names.
inline SegmentationCase ReadSegmentationCase(const std::filesystem::path& folder, const std::string& name) {
  std::ifstream in(folder / (name + ".json"));
  if (!in) throw std::runtime_error("no case " + (folder / name).string());
  const nlohmann::json json = nlohmann::json::parse(in);
  SegmentationCase result;
  result.mesh = ReadOff(folder / json.at("mesh").get<std::string>());
  result.labels = json.at("label_per_triangle").get<std::vector<int>>();
  result.charge.density = json.at("charge_density_Q1000").get<std::vector<double>>();
  for (double& d : result.charge.density) d /= 1000.0;
  result.n_parts = json.at("true_parts");
  return result;
}

// The mesh with Gaussian noise of standard deviation `sigma` on every coordinate (own transform: the same on all
// systems).
inline TriangleMesh WithNoise(TriangleMesh mesh, double sigma, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const auto uniform = [&] { return (static_cast<double>(random() >> 11) + 0.5) * 0x1p-53; };
  for (Eigen::Vector3d& v : mesh.vertices) {
    for (int k = 0; k < 3; ++k) {
      const double radius = std::sqrt(-2.0 * std::log(uniform())), angle = 2.0 * std::numbers::pi * uniform();
      v[k] += sigma * radius * std::cos(angle);
    }
  }
  return mesh;
}

// The diagonal of the box around the vertices, m.
inline double BoxDiagonal(const TriangleMesh& mesh) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& v : mesh.vertices) box.extend(v);
  return box.diagonal().norm();
}

// The share of pairs of triangles on which two labellings agree (together in both or apart in both).
inline double RandIndex(const std::vector<int>& a, const std::vector<int>& b) {
  std::map<int, double> in_a, in_b;
  std::map<std::pair<int, int>, double> in_both;
  for (std::size_t i = 0; i < a.size(); ++i) {
    in_a[a[i]] += 1.0;
    in_b[b[i]] += 1.0;
    in_both[{a[i], b[i]}] += 1.0;
  }
  const auto pairs = [](const auto& counts) {
    double sum = 0.0;
    for (const auto& [key, n] : counts) sum += n * (n - 1.0) / 2.0;
    return sum;
  };
  const double n = static_cast<double>(a.size()), all = n * (n - 1.0) / 2.0;
  return (all + 2.0 * pairs(in_both) - pairs(in_a) - pairs(in_b)) / all;
}

}  // namespace geond::test
