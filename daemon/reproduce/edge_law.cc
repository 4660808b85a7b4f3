// SPDX-License-Identifier: Apache-2.0
// The charge beside an edge, rho ~ eta^(pi/beta - 1) (4.1), beta the angle of the free space (the thesis calls it the angle
// between the planes; only as that of the free space does its (4.2) hold). Measured on sectors of a long cylinder: two planes
// that meet at the axis, the rounded side far from the edge.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/printed.h"
#include "core/charge/charge_density.h"
#include "daemon/reproduce/experiments.h"

namespace geond::reproduce {
namespace {

constexpr double kPi = std::numbers::pi;

// The distance up to which the next term of the expansion, smaller by eta^(2 pi / beta), is below 1 %; 0.4 at most.
double FarEnd(double beta) { return std::min(0.4, std::pow(0.01, 0.5 * beta / kPi)); }

// Heights of the cuts across: even about the middle, wider and wider towards the ends of a length of 4.
std::vector<double> Slices(double even) {
  std::vector<double> up{0.5 * even};
  for (double step = even; up.back() < 1.9; step *= up.back() < 0.5 ? 1.0 : 1.6) up.push_back(std::min(2.0, up.back() + step));
  up.back() = 2.0;
  std::vector<double> z;
  for (std::size_t i = up.size(); i-- > 0;) z.push_back(-up[i]);
  z.insert(z.end(), up.begin(), up.end());
  return z;
}

// Distances of the rings from the edge. Beside a convex edge, where the density grows without bound, by a ratio, so that one
// ring looks like the other; in a notch, where it vanishes, evenly: there the errors of unequal rings outweigh what is left.
std::vector<double> Rings(double beta, double ratio, int even) {
  std::vector<double> radii{0.0};
  if (beta <= kPi) {
    for (int i = 1; i <= even; ++i) radii.push_back(static_cast<double>(i) / even);
    return radii;
  }
  radii.push_back(FarEnd(beta) / 32.0);
  while (radii.back() * ratio < 0.85) radii.push_back(radii.back() * ratio);
  radii.push_back(1.0);
  return radii;
}

// A sector of a cylinder of radius 1 about z, of interior angle `alpha`, its edge on the axis; `cuts` are the heights of the
// cuts across.
TriangleMesh Sector(double alpha, const std::vector<double>& radii, const std::vector<double>& cuts) {
  const int rings = static_cast<int>(radii.size()) - 1, arcs = std::max(3, static_cast<int>(std::lround(alpha / 0.4)));
  TriangleMesh mesh;
  // The patch over a grid of points, its outside where du x dv points.
  const auto patch = [&](int nu, int nv, const auto& point) {
    const int first = static_cast<int>(mesh.vertices.size());
    for (int i = 0; i <= nu; ++i) {
      for (int j = 0; j <= nv; ++j) mesh.vertices.push_back(point(i, j));
    }
    const auto at = [&](int i, int j) { return first + i * (nv + 1) + j; };
    for (int i = 0; i < nu; ++i) {
      for (int j = 0; j < nv; ++j) {
        const int corners[4] = {at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)}, middle = static_cast<int>(mesh.vertices.size());
        Eigen::Vector3d sum = Eigen::Vector3d::Zero();
        for (const int c : corners) sum += mesh.vertices[static_cast<std::size_t>(c)];
        mesh.vertices.push_back(0.25 * sum);
        for (int k = 0; k < 4; ++k) mesh.triangles.push_back({corners[k], corners[(k + 1) % 4], middle});
      }
    }
  };
  const auto place = [&](double r, double angle, double z) -> Eigen::Vector3d {
    return {r * std::cos(angle), r * std::sin(angle), z};
  };
  const int slices = static_cast<int>(cuts.size()) - 1;
  const auto z = [&](int j) { return cuts[static_cast<std::size_t>(j)]; };
  const auto angle = [&](int i) { return alpha * (static_cast<double>(i) / arcs - 0.5); };
  patch(rings, slices, [&](int i, int j) { return place(radii[i], -0.5 * alpha, z(j)); });
  patch(rings, slices, [&](int i, int j) { return place(radii[i], 0.5 * alpha, z(slices - j)); });
  patch(arcs, slices, [&](int i, int j) { return place(1.0, angle(i), z(j)); });
  // The ends, far from where the density is measured and cut coarsely; at the axis the squares are triangles.
  const int steps = std::max(2, arcs / 2);
  for (const bool top : {false, true}) {
    patch(6, steps, [&](int i, int j) {
      return place(i / 6.0, alpha * ((top ? j : steps - j) / static_cast<double>(steps) - 0.5), top ? z(slices) : z(0));
    });
  }
  std::erase_if(mesh.triangles, [&](const TriangleMesh::Triangle& t) {
    const auto& v = mesh.vertices;
    return (v[t[1]] - v[t[0]]).cross(v[t[2]] - v[t[0]]).norm() == 0.0;
  });
  return mesh;
}

struct Profile {
  std::vector<double> distance, density;  // rings from the edge outward, at half the height
  double exponent = 0.0;                  // fitted between the two distances below
  double from = 0.0, to = 0.0;
};

// Density over distance from the edge on the two planes, at half the height, and its exponent up to FarEnd.
Profile Measure(const TriangleMesh& mesh, const std::vector<double>& density, double beta, double even) {
  const double alpha = 2.0 * kPi - beta;
  std::vector<std::pair<double, double>> found;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Eigen::Vector3d c = TriangleCentroid(mesh, static_cast<int>(t));
    const double eta = std::hypot(c.x(), c.y());
    const bool on_plane = std::abs(std::abs(std::atan2(c.y(), c.x())) - 0.5 * alpha) < 1e-9;
    if (on_plane && std::abs(c.z()) < 0.5 * even) found.emplace_back(eta, density[t]);
  }
  std::sort(found.begin(), found.end());
  Profile profile;
  for (const auto& [eta, rho] : found) {
    profile.distance.push_back(eta);
    profile.density.push_back(rho);
  }
  profile.to = FarEnd(beta);
  profile.from = profile.to / (beta < kPi ? 3.0 : 8.0);
  double n = 0, sx = 0, sy = 0, sxx = 0, sxy = 0;
  for (const auto& [eta, rho] : found) {
    if (eta < profile.from || eta > profile.to || !(rho > 0.0)) continue;
    const double x = std::log(eta), y = std::log(rho);
    n += 1, sx += x, sy += y, sxx += x * x, sxy += x * y;
  }
  profile.exponent = (n * sxy - sx * sy) / (n * sxx - sx * sx);
  return profile;
}

}  // namespace

Experiment EdgeLaw(const Run& run) {
  Experiment e;
  e.title = "Fig. 4.3, equation (4.1): the charge beside an edge";
  e.what =
      "Two planes that meet in an edge, as sectors of a cylinder of radius 1 and height 4. The density at half the height is "
      "measured over the distance eta from the edge; its exponent is fitted over a factor 8 of distance (3 in notches), where the "
      "next term of the theory is below 1 %. beta is the angle of the free space. Repaired: exact dense solve; today: the default solver.";
  const double even = run.quick ? 0.2 : 0.1, ratio = run.quick ? 1.6 : 1.4;
  const int rings = run.quick ? 24 : 32;
  const std::vector<int> angles = run.quick ? std::vector<int>{60, 120, 180, 270, 300}
                                            : std::vector<int>{60, 90, 120, 150, 180, 210, 240, 270, 300};
  Plot density{"Charge density over distance from the edge (relative to that at 0.1)", {"distance from the edge eta, radii", true},
               {"density / density at 0.1", true}, {}};
  Plot exponents{"Exponent of the density over the angle of the free space", {"beta, degrees"}, {"exponent", false}, {}};
  Series theory{"pi/beta - 1", {}, {}, Series::Kind::kLine}, measured{"measured", {}, {}, Series::Kind::kMarks};
  for (int beta = 55; beta <= 305; beta += 5) {
    theory.x.push_back(beta);
    theory.y.push_back(180.0 / beta - 1.0);
  }
  double worst_repaired = 0.0, worst_today = 0.0;
  int done = 0;
  for (const int degrees : angles) {
    run.Progress("figure_4_3", done++, static_cast<int>(angles.size()));
    const double beta = degrees * kPi / 180.0, expected = kPi / beta - 1.0;
    const TriangleMesh mesh = Sector(2.0 * kPi - beta, Rings(beta, ratio, rings), Slices(even));
    ChargeOptions exact;
    exact.solver = ChargeOptions::Solver::kDense;
    exact.tolerance = 1e-8;
    exact.threads = run.threads;
    ChargeOptions usual;
    usual.threads = run.threads;
    const Profile repaired = Measure(mesh, SolveChargeDensity(mesh, exact, run.stop).density, beta, even);
    const Profile today = Measure(mesh, SolveChargeDensity(mesh, usual, run.stop).density, beta, even);
    Figure figure{Printed("exponent_%d", degrees), Printed("exponent at beta = %d degrees", degrees), "", expected, repaired.exponent,
                  today.exponent, Figure::Better::kSame, 0.01, 0.003, {}};
    e.figures.push_back(figure);
    if (degrees != 180) {
      worst_repaired = std::max(worst_repaired, 100.0 * std::abs(repaired.exponent / expected - 1.0));
      worst_today = std::max(worst_today, 100.0 * std::abs(today.exponent / expected - 1.0));
    }
    measured.x.push_back(degrees);
    measured.y.push_back(today.exponent);
    Series curve{Printed("%d degrees", degrees), today.distance, today.density, Series::Kind::kLineAndMarks};
    std::size_t at = 0;
    while (at + 1 < curve.x.size() && curve.x[at] < 0.1) ++at;
    const double reference = curve.y[at];
    for (double& y : curve.y) y /= reference;
    if (degrees % 60 == 0 || degrees == 270) density.series.push_back(curve);
  }
  e.figures.push_back({"worst_error", "largest error of an exponent (180 degrees apart)", "%", {}, worst_repaired, worst_today,
                       Figure::Better::kLess, 0.2, 0.1, 3.0});
  exponents.series = {theory, measured};
  e.plots = {density, exponents};
  e.judgement = Printed(
      "The law holds: the solved exponents differ from pi/beta - 1 by at most %.2f %% (exact solve) and %.2f %% (default "
      "solver) - provided beta is read as the angle of the free space, which the thesis does not say.",
      worst_repaired, worst_today);
  return e;
}

}  // namespace geond::reproduce
