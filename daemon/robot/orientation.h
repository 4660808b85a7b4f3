// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>

namespace geond::daemon {

// The ways in which robot controllers write a rotation. Each pair is inverse to the other, also where angles are singular.

// Axis times angle, rad; the angle in [0, pi].
Eigen::Vector3d ToRotationVector(const Eigen::Quaterniond& rotation);
Eigen::Quaterniond FromRotationVector(const Eigen::Vector3d& vector);

// (yaw, pitch, roll), rad, of Rz(yaw) Ry(pitch) Rx(roll): KUKA's A B C; backwards, FANUC's R P W. The pitch is in
// [-pi/2, pi/2]; where it is at an end the roll is 0.
Eigen::Vector3d ToYawPitchRoll(const Eigen::Quaterniond& rotation);
Eigen::Quaterniond FromYawPitchRoll(const Eigen::Vector3d& yaw_pitch_roll);

}  // namespace geond::daemon
