// SPDX-License-Identifier: Apache-2.0
// The charge density against what is known, in one table: closed forms (discretisation error), and the fast solver
// against the exact matrix (its own error) at the default tolerance and at 1e-6. Each line says what was measured, the
// bar, and whether it holds. Usage: charge_accuracy_validation [most triangles of the exact matrix, 5200] [folder of
// the Princeton benchmark's off files]. Exits 1 if a bar is missed.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <numbers>
#include <string>
#include <vector>

#include "core/charge/charge_density.h"
#include "core/geometry/mesh_files.h"
#include "core/surface/remesh.h"
#include "tests/core/charge/shapes.h"

namespace {

using namespace geond;
using Eigen::Vector3d;

int missed = 0;

void Row(const std::string& what, std::size_t triangles, const char* quantity, double measured, double bar) {
  const bool holds = std::abs(measured) <= bar;
  missed += !holds;
  std::printf("%-34s %7zu  %-24s %+.2e  %.1e  %s\n", what.c_str(), triangles, quantity, measured, bar,
              holds ? "holds" : "MISSED");
  std::fflush(stdout);
}

ChargeDensity Solve(const TriangleMesh& mesh, ChargeOptions::Solver solver, double tolerance) {
  ChargeOptions options;
  options.solver = solver;
  options.tolerance = tolerance;
  return SolveChargeDensity(mesh, options);
}

// The figures of centroid collocation on these meshes, 5 % allowed; the last level has no figure of its own and is held
// to half of the one before.
void Ellipsoids() {
  struct Case {
    Vector3d axes;
    double rms[4];
  };
  for (const Case& c : {Case{{1, 1, 1}, {.022, .0064, .0020, .0010}}, Case{{1, 2, 3}, {.024, .0069, .0023, .00115}},
                        Case{{1, 1, 5}, {.028, .010, .0044, .0022}}}) {
    const double a = c.axes.x(), b = c.axes.y(), d = c.axes.z();
    const std::string name =
        "ellipsoid " + std::to_string(int(a)) + ":" + std::to_string(int(b)) + ":" + std::to_string(int(d));
    for (int level : {2, 3, 4, 5}) {
      const TriangleMesh mesh = shapes::Ellipsoid(level, a, b, d);
      const ChargeDensity charge = Solve(mesh, ChargeOptions::Solver::kAuto, 1e-4);
      std::vector<double> exact;
      for (int i = 0; i < static_cast<int>(mesh.triangles.size()); ++i) {
        Vector3d p = TriangleCentroid(mesh, i);
        p /= p.cwiseQuotient(c.axes).norm();
        exact.push_back(shapes::EllipsoidDensity(p, a, b, d));
      }
      Row(name, mesh.triangles.size(), "density rms", shapes::RelativeRms(mesh, charge.density, exact),
          1.05 * c.rms[level - 2]);
      const double high[4] = {.017, .0043, .00105, .00053};
      Row(name, mesh.triangles.size(), "potential/exact - 1",
          charge.potential * shapes::EllipsoidCapacitance(a, b, d) - 1.0, high[level - 2]);
    }
  }
}

// A flat disk of radius 1, rings crowded towards its edge, where the density grows like 1/sqrt(distance).
TriangleMesh Disk(int rings) {
  TriangleMesh mesh;
  const int columns = 4 * rings;
  mesh.vertices.emplace_back(0, 0, 0);
  for (int ring = 1; ring <= rings; ++ring) {
    const double r = std::sin(0.5 * std::numbers::pi * ring / rings);
    for (int j = 0; j < columns; ++j) {
      const double u = 2.0 * std::numbers::pi * j / columns;
      mesh.vertices.emplace_back(r * std::cos(u), r * std::sin(u), 0.0);
    }
  }
  const auto at = [&](int ring, int j) { return 1 + (ring - 1) * columns + j % columns; };
  for (int j = 0; j < columns; ++j) {
    mesh.triangles.push_back({0, at(1, j), at(1, j + 1)});
    for (int ring = 1; ring < rings; ++ring) {
      mesh.triangles.push_back({at(ring, j), at(ring + 1, j), at(ring + 1, j + 1)});
      mesh.triangles.push_back({at(ring, j), at(ring + 1, j + 1), at(ring, j + 1)});
    }
  }
  return mesh;
}

void Capacitances() {
  const auto capacitance = [](const char* name, const TriangleMesh& mesh, double exact, double bar) {
    Row(name, mesh.triangles.size(), "capacitance/exact - 1",
        Solve(mesh, ChargeOptions::Solver::kAuto, 1e-4).capacitance / exact - 1.0, bar);
  };
  capacitance("cube, crowded edges", shapes::Cube(20, 3.0), 0.66067815409957, 3e-4);
  capacitance("cube, crowded edges", shapes::Cube(40, 3.0), 0.66067815409957, 1e-4);
  capacitance("spheres at right angles", shapes::Peanut(24), shapes::kPeanutCapacitance, 3e-3);
  capacitance("spheres at right angles", shapes::Peanut(48), shapes::kPeanutCapacitance, 1e-3);
  TriangleMesh right = shapes::Sphere(4);
  for (Vector3d& v : right.vertices) v.x() += 2.0;
  capacitance("two spheres that touch", shapes::Merged(shapes::Sphere(4), right), 2.0 * std::numbers::ln2, 2e-3);
  capacitance("torus 2 : 1", shapes::Torus(2.0, 1.0, 96, 48), 2.431670412453, 1.5e-3);
  capacitance("torus 2 : 1", shapes::Torus(2.0, 1.0, 192, 96), 2.431670412453, 5e-4);
  capacitance("disk", Disk(20), 2.0 / std::numbers::pi, 3e-3);
  capacitance("disk", Disk(48), 2.0 / std::numbers::pi, 1e-3);
}

// Cuts crowded towards the edges so that the largest triangle has 1,000 times the area of the smallest.
TriangleMesh GradedCube(int n) {
  double grading = 1.0;
  while (grading * std::pow(0.5 * n, grading - 1.0) < std::sqrt(1000.0)) grading += 0.001;
  return shapes::Cube(n, grading);
}

void FastAgainstExact(std::size_t most, const std::filesystem::path& benchmark) {
  const auto compare = [&](const std::string& name, const TriangleMesh& mesh) {
    if (mesh.triangles.size() > most) return;
    const ChargeDensity exact = Solve(mesh, ChargeOptions::Solver::kDense, 1e-9);
    const std::vector<double> areas = TriangleAreas(mesh);
    const double area = Area(mesh);
    for (double tolerance : {5e-4, 1e-6}) {
      const ChargeDensity fast = Solve(mesh, ChargeOptions::Solver::kFast, tolerance);
      double squares = 0.0, largest = 0.0;
      for (std::size_t i = 0; i < areas.size(); ++i) {
        const double difference = std::abs(fast.density[i] - exact.density[i]) * area;
        squares += areas[i] / area * difference * difference;
        largest = std::max(largest, difference);
      }
      const std::string label = tolerance > 1e-5 ? "fast - exact" : "fast - exact at 1e-6";
      Row(name, mesh.triangles.size(), (label + ", rms").c_str(), std::sqrt(squares), tolerance);
      Row(name, mesh.triangles.size(), (label + ", worst").c_str(), largest, 10.0 * tolerance);
      Row(name, mesh.triangles.size(), "error estimated", fast.error_estimate, tolerance);
    }
  };
  compare("sphere", shapes::Sphere(4));
  compare("cube", shapes::Cube(20));
  compare("cube, area ratio 1000", GradedCube(20));
  compare("two spheres", shapes::Peanut(30));
  compare("torus", shapes::Torus(2.0, 0.5, 80, 30));
  TriangleMesh lid = shapes::Cube(14);
  for (Vector3d& v : lid.vertices) v = Vector3d(v.x(), v.y(), 0.1 * v.z() + 1.01);
  compare("thin gap", shapes::Merged(shapes::Cube(14), lid));
  for (const auto& [name, id] : {std::pair{"teddy (161)", 161}, {"vase (361)", 361}}) {
    const std::filesystem::path file = benchmark / (std::to_string(id) + ".off");
    if (benchmark.empty() || !std::filesystem::exists(file)) {
      std::printf("%-34s          left out: no %s\n", name, file.string().c_str());
      continue;
    }
    const TriangleMesh mesh = ReadGeometry(file).mesh;
    for (int wanted : {5000, 10000}) {
      RemeshOptions options;
      options.triangles = wanted;
      compare(name, Remesh(mesh, options));
    }
  }
  compare("cube", shapes::Cube(29));
  compare("cube, area ratio 1000", GradedCube(29));
}

}  // namespace

int main(int argc, char** argv) {
  std::puts("shape                              triangles quantity                 measured   bar");
  Ellipsoids();
  Capacitances();
  FastAgainstExact(argc > 1 ? std::strtoul(argv[1], nullptr, 10) : 5200, argc > 2 ? argv[2] : "");
  std::printf("%d missed\n", missed);
  return missed > 0;
}
