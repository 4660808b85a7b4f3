// SPDX-License-Identifier: Apache-2.0
#include "calib/shown_directions.h"

#include <cmath>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include "core/base/printed.h"

namespace geond::calib {
namespace {

constexpr double kNoiseShare = 1.25;  // of the part by noisy normals that is taken off (hidden directions show 0.8 to 1.3)
constexpr double kLeast = 16.0;       // information over that of the prior: the data must say it four times better

std::string Direction(const Eigen::Vector3d& d) {
  if (std::abs(d.z()) > 0.985) return "the table's axis";
  return Printed("(%.2f, %.2f, %.2f)", d.x(), d.y(), d.z());
}

}  // namespace

ShownDirections FindShownDirections(const Eigen::MatrixXd& H, const Eigen::MatrixXd& noise,
                                    const Eigen::VectorXd& deviations) {
  Eigen::MatrixXd information = H - kNoiseShare * noise;
  information = deviations.asDiagonal() * information * deviations.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(0.5 * (information + information.transpose()));
  Eigen::Index hidden = 0;
  while (hidden < H.rows() && eigen.eigenvalues()[hidden] < kLeast) ++hidden;
  return {eigen.eigenvectors().rightCols(H.rows() - hidden), eigen.eigenvectors().leftCols(hidden)};
}

std::vector<std::string> DescribeHiddenMotions(const Eigen::MatrixXd& H, const Eigen::MatrixXd& noise,
                                               const Eigen::VectorXd& deviations, const Eigen::Vector3d& center_T,
                                               double length) {
  const Eigen::MatrixXd hidden = deviations.asDiagonal() * FindShownDirections(H, noise, deviations).hidden;
  if (hidden.cols() == 0) return {};
  if (hidden.cols() == 6) return {"the views show no common surface: nothing of their poses can be refined"};

  // Orthonormal in metres, translations first: motions that are rotations at all keep their rotation.
  std::vector<std::string> words;
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(hidden.topRows(3), Eigen::ComputeFullU | Eigen::ComputeFullV);
  int turns = 0;
  const double largest = hidden.norm();
  std::vector<Eigen::VectorXd> rotations, slides;
  for (Eigen::Index k = 0; k < hidden.cols(); ++k) {
    const Eigen::VectorXd motion = hidden * svd.matrixV().col(k);
    const double turn = k < svd.singularValues().size() ? svd.singularValues()[k] : 0.0;
    if (turn > 0.3 * motion.tail(3).norm() && turn > 1e-3 * largest) {
      rotations.push_back(motion);
      ++turns;
    } else {
      slides.push_back(motion);
    }
  }
  if (turns == 3) {
    words.push_back("the shape shows no rotation (a sphere): rotations stay as measured");
  } else {
    for (const auto& motion : rotations) {
      const Eigen::Vector3d w = motion.head(3) / length, d = w.normalized();
      const Eigen::Vector3d at = center_T + w.cross(Eigen::Vector3d(motion.tail(3))) / w.squaredNorm();
      words.push_back(Printed("the shape shows no turn about %s through (%.0f, %.0f, %.0f) mm (a solid of revolution): "
                              "it stays as measured", Direction(d).c_str(), at.x() * 1e3, at.y() * 1e3, at.z() * 1e3));
    }
  }
  for (const auto& motion : slides) {
    words.push_back(Printed("the shape shows no shift along %s (a prism or a plane): it stays as measured",
                            Direction(Eigen::Vector3d(motion.tail(3)).normalized()).c_str()));
  }
  return words;
}

}  // namespace geond::calib
