// SPDX-License-Identifier: Apache-2.0
// The charge density against what is known: closed forms (discretisation error), and the fast solver against the exact
// matrix (its own error) at the default tolerance and at 1e-6. Usage: charge_accuracy_validation [most triangles of the
// exact matrix, 5200].
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "core/charge/charge_density.h"
#include "tests/core/charge/shapes.h"

namespace {

using namespace geond;
using Eigen::Vector3d;

ChargeDensity Solve(const TriangleMesh& mesh, ChargeOptions::Solver solver, double tolerance) {
  ChargeOptions options;
  options.solver = solver;
  options.tolerance = tolerance;
  return SolveChargeDensity(mesh, options);
}

void Ellipsoids() {
  std::puts("ellipsoids: rms of density / exact - 1, potential / exact - 1");
  for (const Vector3d& axes : {Vector3d(1, 1, 1), Vector3d(1, 2, 3), Vector3d(1, 1, 5)}) {
    for (int level : {2, 3, 4, 5}) {
      const TriangleMesh mesh = shapes::Ellipsoid(level, axes.x(), axes.y(), axes.z());
      const ChargeDensity charge = Solve(mesh, ChargeOptions::Solver::kAuto, 1e-4);
      std::vector<double> exact;
      for (int i = 0; i < static_cast<int>(mesh.triangles.size()); ++i) {
        Vector3d p = TriangleCentroid(mesh, i);
        p /= p.cwiseQuotient(axes).norm();
        exact.push_back(shapes::EllipsoidDensity(p, axes.x(), axes.y(), axes.z()));
      }
      std::printf("  %g:%g:%g  %6zu  %.3f %%  %.3f %%\n", axes.x(), axes.y(), axes.z(), mesh.triangles.size(),
                  100.0 * shapes::RelativeRms(mesh, charge.density, exact),
                  100.0 * (charge.potential * shapes::EllipsoidCapacitance(axes.x(), axes.y(), axes.z()) - 1.0));
    }
  }
}

void Capacitances() {
  std::puts("capacitance / exact - 1");
  for (int n : {10, 20, 30, 40}) {
    const TriangleMesh mesh = shapes::Cube(n, 3.0);
    std::printf("  cube, graded  %6zu  %+.2e\n", mesh.triangles.size(),
                Solve(mesh, ChargeOptions::Solver::kAuto, 1e-4).capacitance / 0.66067815409957 - 1.0);
  }
  for (int rings : {12, 24, 48}) {
    const TriangleMesh mesh = shapes::Peanut(rings);
    std::printf("  two spheres at right angles  %6zu  %+.2e\n", mesh.triangles.size(),
                Solve(mesh, ChargeOptions::Solver::kAuto, 1e-4).capacitance / shapes::kPeanutCapacitance - 1.0);
  }
  for (int n : {24, 48, 96}) {
    const TriangleMesh mesh = shapes::Torus(2.0, 1.0, 2 * n, n);
    std::printf("  torus 2 : 1  %6zu  %+.2e\n", mesh.triangles.size(),
                Solve(mesh, ChargeOptions::Solver::kAuto, 1e-4).capacitance / 2.431670412453 - 1.0);
  }
}

void FastAgainstExact(std::size_t most) {
  std::puts("fast against the exact matrix, relative to the mean density: rms, largest");
  const auto compare = [&](const char* name, const TriangleMesh& mesh) {
    if (mesh.triangles.size() > most) return;
    const ChargeDensity exact = Solve(mesh, ChargeOptions::Solver::kDense, 1e-9);
    const std::vector<double> areas = TriangleAreas(mesh);
    const double area = Area(mesh);
    std::printf("  %-24s %6zu", name, mesh.triangles.size());
    for (double tolerance : {5e-4, 1e-6}) {
      const ChargeDensity fast = Solve(mesh, ChargeOptions::Solver::kFast, tolerance);
      double squares = 0.0, largest = 0.0;
      for (std::size_t i = 0; i < areas.size(); ++i) {
        const double difference = std::abs(fast.density[i] - exact.density[i]) * area;
        squares += areas[i] / area * difference * difference;
        largest = std::max(largest, difference);
      }
      std::printf("   at %.0e: %.1e %.1e", tolerance, std::sqrt(squares), largest);
    }
    std::printf("   least density / mean %+.3f\n", *std::min_element(exact.density.begin(), exact.density.end()) * area);
    std::fflush(stdout);
  };
  compare("sphere", shapes::Sphere(4));
  compare("cube", shapes::Cube(20));
  compare("cube, area ratio 1000", shapes::Cube(20, 2.6));
  compare("two spheres", shapes::Peanut(30));
  compare("torus", shapes::Torus(2.0, 0.5, 80, 30));
  TriangleMesh lid = shapes::Cube(14);
  for (Vector3d& v : lid.vertices) v = Vector3d(v.x(), v.y(), 0.1 * v.z() + 1.01);
  compare("thin gap", shapes::Merged(shapes::Cube(14), lid));
  compare("cube", shapes::Cube(29));
}

}  // namespace

int main(int argc, char** argv) {
  Ellipsoids();
  Capacitances();
  FastAgainstExact(argc > 1 ? std::strtoul(argv[1], nullptr, 10) : 5200);
}
