// SPDX-License-Identifier: Apache-2.0
#include <chrono>
#include <numbers>

#include "core/base/error.h"
#include "daemon/robot/orientation.h"
#include "daemon/service.h"

namespace geond::daemon {
namespace {

using Code = RpcError::Code;

Pose PoseFromJson(const Json& json) {
  const Json& p = json.at("position_mm");
  const Json& q = json.at("quaternion");
  return Pose(Eigen::Quaterniond(q.at("w"), q.at("x"), q.at("y"), q.at("z")),
              1e-3 * Eigen::Vector3d(p[0].get<double>(), p[1].get<double>(), p[2].get<double>()));
}

double NumberOr(const Json& value, double fallback) { return value.is_number() ? value.get<double>() : fallback; }

RobotStatus StatusOf(const RpcError& error) {
  if (error.code() == Code::kBusy) return RobotStatus::kBusy;
  if (error.code() == Code::kUnsafe) return RobotStatus::kUnsafe;
  if (error.code() == Code::kNotFound || error.code() == Code::kUnavailable) return RobotStatus::kNoObject;
  return RobotStatus::kFailed;
}

}  // namespace

// Where the table stands in the base of the robot; nothing while its angle is not known.
std::optional<Pose> Service::TableInRobot() const {
  if (!table_angle_) return std::nullopt;
  constexpr double kRadians = std::numbers::pi / 180.0;
  const Pose X_RW(FromYawPitchRoll(kRadians * Eigen::Vector3d(config_.robot_base_yaw_deg, config_.robot_base_pitch_deg,
                                                              config_.robot_base_roll_deg)),
                  1e-3 * Eigen::Vector3d(config_.robot_base_x_mm, config_.robot_base_y_mm, config_.robot_base_z_mm));
  return X_RW * Geometry().X_WT * Pose::Rotation(Eigen::Vector3d::UnitZ(), *table_angle_);
}

RobotStatus Service::StateForRobot() const {
  if (!latched_.empty()) return RobotStatus::kUnsafe;
  if (state_ != State::kIdle) return RobotStatus::kBusy;
  if (store_.newest() == 0) return RobotStatus::kNoObject;
  return store_.newest() == store_.newest_done() ? RobotStatus::kOk : RobotStatus::kFailed;
}

RobotRecord Service::AnswerRobot(const RobotRequest& request) {
  RobotRecord record;
  try {
    switch (request.verb) {
      case RobotVerb::kScan:
        record.scan = StartScan(config_.scan_views, config_.scan_first_angle_deg * std::numbers::pi / 180.0, "robot")
                          .at("scan").get<int>();
        return record;
      case RobotVerb::kStop:
        StopAll("asked for by the robot");
        return record;
      case RobotVerb::kStatus:
        record.status = StateForRobot();
        record.scan = store_.newest();
        if (record.status != RobotStatus::kOk) return record;
        break;
      default:
        break;
    }
    FillObject(request, record);
  } catch (const RpcError& error) {
    record.status = StatusOf(error);
  } catch (const std::exception&) {
    record.status = RobotStatus::kFailed;  // a description that cannot be read
  }
  return record;
}

// The object of the last description, or one of its parts.
void Service::FillObject(const RobotRequest& request, RobotRecord& record) {
  const int id = ScanParameter(Json::object(), true);
  const std::shared_ptr<const Json> description = Description(id);
  const Json& parts = description->at("parts");
  const int n = static_cast<int>(parts.size());
  record.scan = id;
  record.remaining = n;
  record.age = std::chrono::duration<double>(std::chrono::system_clock::now() - FindScan(id).ended).count();
  if (request.verb == RobotVerb::kStatus || request.verb == RobotVerb::kObject) return;

  if (request.number > n) {
    record.status = RobotStatus::kNoSuchPart;
    return;
  }
  record.remaining = n - request.number;
  const std::optional<Pose> X_RT = TableInRobot();
  if (!X_RT) {
    record.status = RobotStatus::kPoseUnknown;
    return;
  }
  if (request.verb == RobotVerb::kGrasp) {
    for (const Json& grasp : Grasps(id)->at("grasps")) {
      if (grasp.at("part") != request.number) continue;
      record.X_RG = *X_RT * PoseFromJson(grasp.at("pose"));
      record.size.x() = 1e-3 * grasp.at("opening_mm").get<double>();
      record.confidence = grasp.at("quality").get<double>();
      return;
    }
    record.status = RobotStatus::kNoSuchPart;
    return;
  }
  const Json& part = parts[request.number - 1];
  const Json& size = part.at("size_mm");
  record.type = part.at("type_index").get<int>();
  record.X_RG = *X_RT * PoseFromJson(part.at("pose"));
  record.size = 1e-3 * Eigen::Vector3d(size[0].get<double>(), size[1].get<double>(), size[2].get<double>());
  record.taper = 0.5 * (part.at("taper")[0].get<double>() + part.at("taper")[1].get<double>());
  record.bend = 1e3 * part.at("bend_per_mm").get<double>();
  record.confidence = NumberOr(part.at("confidence"), 0.0);
}

Json GraspsJson(const ObjectDescription& description, const Gripper& gripper) {
  std::vector<Geon> geons;
  for (const DescribedPart& part : description.parts) geons.push_back(part.geon());
  Json all = Json::array();
  for (int part = 0; part < static_cast<int>(geons.size()); ++part) {
    for (const Grasp& grasp : FindGrasps(geons, part, gripper)) {
      const Eigen::Quaterniond& q = grasp.X_TH.rotation();
      const Eigen::Vector3d p = 1e3 * grasp.X_TH.translation();
      all.push_back({{"part", description.parts[part].id},
                     {"pose", {{"position_mm", {p.x(), p.y(), p.z()}},
                               {"quaternion", {{"w", q.w()}, {"x", q.x()}, {"y", q.y()}, {"z", q.z()}}}}},
                     {"opening_mm", 1e3 * grasp.opening},
                     {"clearance_mm", 1e3 * grasp.clearance},
                     {"quality", grasp.quality},
                     {"reason", grasp.reason}});
    }
  }
  return {{"grasps", std::move(all)}};
}

}  // namespace geond::daemon
