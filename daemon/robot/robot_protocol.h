// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "core/geometry/pose.h"

// What robot controllers say and hear on the robot port: one ASCII line in, one line of a fixed shape out. Pure functions.
// docs/robots says of each controller how its own parser reads these lines.
namespace geond::daemon {

inline constexpr std::size_t kMaxRobotLine = 80;

enum class RobotDialect { kUr, kAbb, kKuka, kFanuc, kPlain };
// "UR", "ABB", "KUKA", "FANUC", "PLAIN". Nothing if there is no such dialect; letters may be small.
std::optional<RobotDialect> RobotDialectFromName(std::string_view name);

enum class RobotVerb { kScan, kStatus, kObject, kPart, kPose, kGrasp, kStop };
struct RobotRequest {
  RobotVerb verb = RobotVerb::kStatus;
  int number = 1;  // of the part, from 1, for the verbs that take one
};
// "SCAN", "STATUS", "OBJECT", "PART n", "POSE n", "GRASP n", "STOP"; letters may be small, blanks many. Nothing if it is
// none of them.
std::optional<RobotRequest> ParseRobotRequest(std::string_view line);

enum class RobotStatus {
  kOk = 0,
  kBusy = 1,          // a scan runs, or the station does something else
  kNoObject = 2,      // nothing has been described yet
  kNoSuchPart = 3,    // or no grasp of it that is free
  kUnsafe = 4,        // stopped; a person must reset it
  kFailed = 5,        // the last scan failed
  kBadRequest = 6,    // the line is none of the verbs, or too long
  kPoseUnknown = 7,   // the table's angle is not known: the object's place is not either
};

// All a controller is told. A verb that has nothing to say in a field leaves it 0.
struct RobotRecord {
  RobotStatus status = RobotStatus::kOk;
  int type = 0;                 // 1 to 7 (core/geon/geon.h); of GRASP 0
  int remaining = 0;            // parts after this one; of SCAN, STATUS, OBJECT: all parts
  Pose X_RG;                    // of the part, or of the gripper, in the robot's base
  Eigen::Vector3d size = Eigen::Vector3d::Zero();  // half sizes along the part's axes, m; of GRASP x is the opening
  double taper = 0.0;           // the mean of Kx and Ky
  double bend = 0.0;            // 1/m
  double confidence = 0.0;      // of the type, 0 to 1; of GRASP its quality
  double age = 0.0;             // s since the description was made
  int scan = 0;                 // its number
};

// The line that answers, without its end. `with_pose` chooses between the two shapes of ABB, whose strings hold 80
// characters: a pose, or everything else.
//   UR     (status,type,remaining,x,y,z,rx,ry,rz,a,b,c,taper,bend,confidence,age): 16 numbers, metres, rotation vector
//   ABB    [[x,y,z],[q1,q2,q3,q4]] in mm with q1 = w, or [status,type,remaining,a,b,c,taper,bend,confidence,age,scan]
//   KUKA   <Geon Status="" ...><Pose X="" Y="" Z="" A="" B="" C=""/></Geon> in mm and degrees
//   FANUC  17 columns of 11 characters: status type remaining x y z w p r a b c taper bend confidence age scan, mm, degrees
//   PLAIN  18 words: status type remaining x y z qw qx qy qz a b c taper bend confidence age scan, mm
std::string RobotAnswer(RobotDialect dialect, const RobotRecord& record, bool with_pose);

// Whether an answer to the verb is about a place.
bool HasPose(RobotVerb verb);

}  // namespace geond::daemon
