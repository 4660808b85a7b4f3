// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

namespace geond::calib {

// Which combinations of parameters the data show. Noise of the normals adds to the Gauss-Newton matrix of directions that
// the shape does not show at all (a sphere's rotations), and would make them look known: that part is taken off first.
struct ShownDirections {
  Eigen::MatrixXd shown;    // columns: orthonormal directions of parameters over their prior deviations
  Eigen::MatrixXd hidden;   // the rest
};
ShownDirections FindShownDirections(const Eigen::MatrixXd& H, const Eigen::MatrixXd& noise,
                                    const Eigen::VectorXd& deviations);

// The motions (of the object as a whole; rotation times length, translation) that leave all overlapping surfaces in place,
// in words. `H` and `noise` as above, 6 x 6, about `center_T`.
std::vector<std::string> DescribeHiddenMotions(const Eigen::MatrixXd& H, const Eigen::MatrixXd& noise,
                                               const Eigen::VectorXd& deviations, const Eigen::Vector3d& center_T,
                                               double length);

}  // namespace geond::calib
