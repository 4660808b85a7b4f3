// SPDX-License-Identifier: Apache-2.0
// Beside sharp creases collocation makes some densities negative. What can be done about it, measured: the potential
// asked for at centroids or averaged over three points of a triangle, each as solved, made of one sign
// (core/charge/one_sign.h), and solved under the condition that no density be negative. The truth is the mean density
// over each triangle cut into sixteen. Usage: charge_creases_validation MESH... (up to 3,000 triangles).
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

#include <Eigen/Dense>

#include "core/charge/charge_density.h"
#include "core/charge/kernels.h"
#include "core/charge/one_sign.h"
#include "core/charge/panels.h"
#include "core/charge/quadrature.h"
#include "core/geometry/mesh_files.h"

namespace {

using namespace geond;
using Eigen::Vector3d;

TriangleMesh CutIntoFour(const TriangleMesh& mesh) {
  TriangleMesh finer;
  for (const auto& [a, b, c] : mesh.triangles) {
    const Vector3d p = mesh.vertices[a], q = mesh.vertices[b], r = mesh.vertices[c];
    const int first = static_cast<int>(finer.vertices.size());
    const std::vector<Vector3d> vertices = {p, q, r, 0.5 * (p + q), 0.5 * (q + r), 0.5 * (r + p)};
    finer.vertices.insert(finer.vertices.end(), vertices.begin(), vertices.end());
    for (const TriangleMesh::Triangle& t : {TriangleMesh::Triangle{0, 3, 5}, {3, 1, 4}, {5, 4, 2}, {3, 4, 5}}) {
      finer.triangles.push_back({first + t[0], first + t[1], first + t[2]});
    }
  }
  return finer;
}

// A_ik, the potential averaged over the points of `rule` on triangle i.
Eigen::MatrixXd Matrix(const TriangleMesh& mesh, std::span<const charge::RulePoint> rule) {
  const int n = static_cast<int>(mesh.triangles.size());
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(n, n);
  std::vector<double> x(n), y(n), z(n);
  Eigen::VectorXd column(n);
  for (const charge::RulePoint& point : rule) {
    for (int i = 0; i < n; ++i) {
      const Vector3d p = charge::PlaceOf(point, mesh, i);
      x[i] = p.x(), y[i] = p.y(), z[i] = p.z();
    }
    for (int k = 0; k < n; ++k) {
      charge::BestKernels().double_precision.triangle_potential(charge::FrameOf(mesh, k), x.data(), y.data(), z.data(),
                                                                n, column.data());
      A.col(k) += point.share * column;
    }
  }
  return A;
}

Eigen::VectorXd Solve(const Eigen::MatrixXd& A) { return A.partialPivLu().solve(Eigen::VectorXd::Ones(A.rows())); }

// The triangles that come out negative are left out of the equations until there are none.
Eigen::VectorXd SolveNotNegative(const Eigen::MatrixXd& A, Eigen::VectorXd x) {
  std::vector<int> kept(A.rows());
  for (int i = 0; i < static_cast<int>(kept.size()); ++i) kept[i] = i;
  while (x.minCoeff() < 0.0) {
    std::erase_if(kept, [&](int i) { return x[i] < 0.0; });
    const Eigen::VectorXd some = Solve(A(kept, kept));
    x.setZero();
    for (std::size_t i = 0; i < kept.size(); ++i) x[kept[i]] = some[static_cast<Eigen::Index>(i)];
  }
  return x;
}

void Measure(const char* file) {
  const TriangleMesh mesh = ReadGeometry(file).mesh;
  const std::vector<double> areas = TriangleAreas(mesh);
  const double area = Area(mesh);
  ChargeOptions options;
  options.one_sign = false;
  const ChargeDensity fine = SolveChargeDensity(CutIntoFour(CutIntoFour(mesh)), options);
  std::vector<double> truth(areas.size(), 0.0);  // relative to the mean
  for (std::size_t i = 0; i < fine.density.size(); ++i) truth[i / 16] += fine.density[i] / 16.0 * area;
  std::printf("%s, %zu triangles\n", file, areas.size());
  for (const auto& [name, rule] :
       {std::pair<const char*, std::span<const charge::RulePoint>>{"centroid", charge::kOnePoint},
        {"average", charge::kThreePoints}}) {
    const auto report = [&, name = name](const char* what, const Eigen::VectorXd& x) {
      double capacitance = 0.0, squares = 0.0, low_squares = 0.0, low_area = 0.0, worst = 0.0;
      for (std::size_t i = 0; i < areas.size(); ++i) capacitance += x[static_cast<Eigen::Index>(i)] * areas[i];
      for (std::size_t i = 0; i < areas.size(); ++i) {
        const double error = x[static_cast<Eigen::Index>(i)] / capacitance * area - truth[i], share = areas[i] / area;
        squares += share * error * error;
        if (truth[i] >= 0.4) continue;
        low_squares += share * error * error, low_area += share;
        worst = std::max(worst, std::abs(error));
      }
      std::printf(
          "  %-8s  %-13s negative %3td  capacitance %+.2e  density rms %.3f, where below 0.4 %.3f, worst %.2f\n", name,
          what, (x.array() < 0.0).count(), capacitance / fine.capacitance - 1.0, std::sqrt(squares),
          std::sqrt(low_squares / std::max(low_area, 1e-12)), worst);
    };
    const Eigen::MatrixXd A = Matrix(mesh, rule);
    const Eigen::VectorXd x = Solve(A);
    report("as solved", x);
    std::vector<double> density(x.data(), x.data() + x.size());
    charge::MakeOneSign(mesh, areas, density);
    report("one sign", Eigen::Map<const Eigen::VectorXd>(density.data(), x.size()));
    report("not negative", SolveNotNegative(A, x));
  }
}

}  // namespace

int main(int argc, char** argv) {
  for (int i = 1; i < argc; ++i) Measure(argv[i]);
}
