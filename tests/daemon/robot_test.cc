// SPDX-License-Identifier: Apache-2.0
// Each dialect is read here as its controller reads it: by its own number formats and length limits.
#include "daemon/robot/robot_protocol.h"

#include <cmath>
#include <cstdlib>
#include <numbers>
#include <random>
#include <regex>
#include <sstream>
#include <vector>

#include <gtest/gtest.h>

#include "daemon/robot/allow_list.h"
#include "daemon/robot/grasp.h"
#include "daemon/robot/orientation.h"

namespace geond::daemon {
namespace {

constexpr double kPi = std::numbers::pi;

double Uniform(std::mt19937_64& random, double low, double high) {
  return low + (high - low) * static_cast<double>(random() >> 11) * 0x1.0p-53;
}

// Angle between two rotations, rad.
double AngleBetween(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b) {
  const Eigen::Quaterniond d = a.conjugate() * b;
  return 2.0 * std::atan2(d.vec().norm(), std::abs(d.w()));
}

// URScript's socket_read_ascii_float: "( a , b , ... )" of at most 30 numbers.
std::vector<double> ReadUr(const std::string& line) {
  EXPECT_EQ(line.front(), '(');
  EXPECT_EQ(line.back(), ')');
  std::vector<double> numbers;
  std::istringstream stream(line.substr(1, line.size() - 2));
  for (std::string word; std::getline(stream, word, ',');) numbers.push_back(std::stod(word));
  EXPECT_EQ(numbers.size(), 16u);
  return numbers;
}
Pose UrPose(const std::string& line) {
  const std::vector<double> n = ReadUr(line);
  return Pose(FromRotationVector({n[6], n[7], n[8]}), {n[3], n[4], n[5]});
}

// RAPID's StrToVal into a pose: a string of at most 80 characters; the quaternion must be normalised.
Pose AbbPose(const std::string& line) {
  EXPECT_LE(line.size(), 80u);
  double v[7];
  EXPECT_EQ(std::sscanf(line.c_str(), "[[%lf,%lf,%lf],[%lf,%lf,%lf,%lf]]", v, v + 1, v + 2, v + 3, v + 4, v + 5, v + 6), 7);
  const Eigen::Quaterniond q(v[3], v[4], v[5], v[6]);
  EXPECT_NEAR(q.norm(), 1.0, 1e-5);
  return Pose(q, 1e-3 * Eigen::Vector3d(v[0], v[1], v[2]));
}

// An attribute of KUKA's XML.
double KukaValue(const std::string& line, const std::string& element, const std::string& attribute) {
  std::smatch match;
  const std::regex pattern("<" + element + "[^>]* " + attribute + "=\"([-0-9.]+)\"");
  EXPECT_TRUE(std::regex_search(line, match, pattern)) << element << " " << attribute << " in " << line;
  return match.empty() ? 0.0 : std::stod(match[1]);
}
Pose KukaPose(const std::string& line) {
  const auto value = [&](const char* attribute) { return KukaValue(line, "Pose", attribute); };
  const Eigen::Quaterniond q = Eigen::AngleAxisd(value("A") * kPi / 180, Eigen::Vector3d::UnitZ()) *
                               Eigen::AngleAxisd(value("B") * kPi / 180, Eigen::Vector3d::UnitY()) *
                               Eigen::AngleAxisd(value("C") * kPi / 180, Eigen::Vector3d::UnitX());
  return Pose(q, 1e-3 * Eigen::Vector3d(value("X"), value("Y"), value("Z")));
}

// FANUC's SUB_STR of fixed columns; a STRING holds at most 254 characters.
double FanucColumn(const std::string& line, int column) {
  EXPECT_EQ(line.size(), 17u * 11u);
  EXPECT_LE(line.size(), 254u);
  return std::stod(line.substr(11 * column, 11));
}
Pose FanucPose(const std::string& line) {
  const Eigen::Quaterniond q = Eigen::AngleAxisd(FanucColumn(line, 8) * kPi / 180, Eigen::Vector3d::UnitZ()) *
                               Eigen::AngleAxisd(FanucColumn(line, 7) * kPi / 180, Eigen::Vector3d::UnitY()) *
                               Eigen::AngleAxisd(FanucColumn(line, 6) * kPi / 180, Eigen::Vector3d::UnitX());
  return Pose(q, 1e-3 * Eigen::Vector3d(FanucColumn(line, 3), FanucColumn(line, 4), FanucColumn(line, 5)));
}

Pose PlainPose(const std::string& line) {
  std::istringstream stream(line);
  std::vector<double> n;
  for (double value; stream >> value;) n.push_back(value);
  EXPECT_EQ(n.size(), 18u);
  return Pose(Eigen::Quaterniond(n[6], n[7], n[8], n[9]), 1e-3 * Eigen::Vector3d(n[3], n[4], n[5]));
}

void ExpectSame(const Pose& got, const Pose& sent, const char* dialect) {
  EXPECT_LT((got.translation() - sent.translation()).norm(), 1e-6) << dialect;
  EXPECT_LT(AngleBetween(got.rotation(), sent.rotation()), 1e-6) << dialect;
}

void ExpectRoundTrip(const Pose& pose) {
  RobotRecord record;
  record.X_RG = pose;
  ExpectSame(UrPose(RobotAnswer(RobotDialect::kUr, record, true)), pose, "UR");
  ExpectSame(AbbPose(RobotAnswer(RobotDialect::kAbb, record, true)), pose, "ABB");
  ExpectSame(FanucPose(RobotAnswer(RobotDialect::kFanuc, record, true)), pose, "FANUC");
  ExpectSame(PlainPose(RobotAnswer(RobotDialect::kPlain, record, true)), pose, "PLAIN");
}

TEST(RobotAnswer, RandomPosesSurviveEveryDialect) {
  std::mt19937_64 random(1);
  for (int i = 0; i < 100000; ++i) {
    Eigen::Vector4d q;
    do {
      for (int k = 0; k < 4; ++k) q[k] = Uniform(random, -1, 1);
    } while (q.norm() > 1.0 || q.norm() < 0.1);
    const Pose pose(Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized(),
                    Eigen::Vector3d(Uniform(random, -3, 3), Uniform(random, -3, 3), Uniform(random, -3, 3)));
    ExpectRoundTrip(pose);
    if (i % 100 == 0) {
      RobotRecord record;
      record.X_RG = pose;
      ExpectSame(KukaPose(RobotAnswer(RobotDialect::kKuka, record, true)), pose, "KUKA");
    }
    if (testing::Test::HasFailure()) break;
  }
}

TEST(RobotAnswer, SingularPosesSurviveEveryDialect) {
  std::vector<Pose> poses;
  for (const double yaw : {0.0, 0.7, kPi, -kPi, kPi / 2}) {
    for (const double pitch : {kPi / 2, -kPi / 2, kPi / 2 - 1e-9, kPi / 2 - 1e-7, -kPi / 2 + 1e-6, 0.0, kPi}) {
      for (const double roll : {0.0, kPi, -kPi / 2, 1.3}) {
        poses.emplace_back(FromYawPitchRoll({yaw, pitch, roll}), Eigen::Vector3d(1, -2, 9.999));
      }
    }
  }
  poses.emplace_back(Eigen::Quaterniond(1, 1e-9, 0, 0), Eigen::Vector3d(-9.999, -9.999, -9.999));
  poses.emplace_back(Eigen::Quaterniond(1e-9, 1, 0, 0), Eigen::Vector3d::Zero());
  poses.emplace_back(Eigen::Quaterniond(0, 0, -1, 0), Eigen::Vector3d::Zero());
  for (const Pose& pose : poses) {
    ExpectRoundTrip(pose);
    RobotRecord record;
    record.X_RG = pose;
    ExpectSame(KukaPose(RobotAnswer(RobotDialect::kKuka, record, true)), pose, "KUKA");
  }
}

TEST(RobotAnswer, EveryFieldArrives) {
  RobotRecord record;
  record.status = RobotStatus::kOk;
  record.type = 4;
  record.remaining = 2;
  record.size = {0.0301, 0.0202, 0.1503};
  record.taper = 0.29;
  record.bend = 3.5;
  record.confidence = 0.97;
  record.age = 12.3;
  record.scan = 17;
  const std::vector<double> ur = ReadUr(RobotAnswer(RobotDialect::kUr, record, false));
  EXPECT_EQ(ur[1], 4);
  EXPECT_EQ(ur[2], 2);
  EXPECT_DOUBLE_EQ(ur[9], 0.0301);
  EXPECT_DOUBLE_EQ(ur[12], 0.29);
  EXPECT_DOUBLE_EQ(ur[13], 3.5);
  EXPECT_DOUBLE_EQ(ur[14], 0.97);
  EXPECT_DOUBLE_EQ(ur[15], 12.3);
  EXPECT_EQ(RobotAnswer(RobotDialect::kAbb, record, false), "[0,4,2,30.10,20.20,150.30,0.290,0.00350,0.97,12,17]");
  EXPECT_EQ(FanucColumn(RobotAnswer(RobotDialect::kFanuc, record, false), 9), 30.1);
  EXPECT_EQ(FanucColumn(RobotAnswer(RobotDialect::kFanuc, record, false), 16), 17);
  const std::string kuka = RobotAnswer(RobotDialect::kKuka, record, false);
  EXPECT_EQ(KukaValue(kuka, "Geon", "Type"), 4);
  EXPECT_EQ(KukaValue(kuka, "Size", "C"), 150.3);
  EXPECT_EQ(KukaValue(kuka, "Size", "Bend"), 0.0035);
  EXPECT_EQ(KukaValue(kuka, "Trust", "Age"), 12.3);
}

TEST(RobotAnswer, NothingBreaksItsShape) {
  const double wild[] = {0.0, -0.0, 1e300, -1e300, NAN, INFINITY, -INFINITY, 1e-300};
  for (const double value : wild) {
    RobotRecord record;
    record.type = 1000;
    record.remaining = -5;
    record.scan = 2000000000;
    record.size = {value, -value, 1.0};
    record.taper = record.bend = record.confidence = record.age = value;
    if (std::isfinite(value)) record.X_RG = Pose::Translation({value, 0, -value});
    EXPECT_EQ(ReadUr(RobotAnswer(RobotDialect::kUr, record, true)).size(), 16u);
    EXPECT_LE(RobotAnswer(RobotDialect::kAbb, record, true).size(), 80u);
    EXPECT_LE(RobotAnswer(RobotDialect::kAbb, record, false).size(), 80u);
    EXPECT_EQ(RobotAnswer(RobotDialect::kFanuc, record, true).size(), 187u);
    for (const RobotDialect dialect : {RobotDialect::kUr, RobotDialect::kAbb, RobotDialect::kKuka, RobotDialect::kFanuc, RobotDialect::kPlain}) {
      const std::string line = RobotAnswer(dialect, record, true);
      EXPECT_EQ(line.find("nan"), std::string::npos);
      EXPECT_EQ(line.find("inf"), std::string::npos);
    }
  }
}

TEST(ParseRobotRequest, ReadsTheVerbs) {
  EXPECT_EQ(ParseRobotRequest("SCAN")->verb, RobotVerb::kScan);
  EXPECT_EQ(ParseRobotRequest("  status  ")->verb, RobotVerb::kStatus);
  EXPECT_EQ(ParseRobotRequest("Part 12")->number, 12);
  EXPECT_EQ(ParseRobotRequest("GRASP\t3")->verb, RobotVerb::kGrasp);
  for (const char* wrong : {"", " ", "PART", "PART 0", "PART -1", "PART 1.5", "PART 1 2", "PART 1000", "PARTS 1", "SCAN 1", "STOP!",
                            "PART 99999999999999999999"}) {
    EXPECT_FALSE(ParseRobotRequest(wrong)) << wrong;
  }
  EXPECT_FALSE(ParseRobotRequest("STATUS" + std::string(80, ' ')));
}

TEST(Orientation, PairsAreInverse) {
  std::mt19937_64 random(2);
  for (int i = 0; i < 10000; ++i) {
    const Eigen::Vector3d v(Uniform(random, -1.8, 1.8), Uniform(random, -1.8, 1.8), Uniform(random, -1.8, 1.8));
    EXPECT_LT((ToRotationVector(FromRotationVector(v)) - v).norm(), 1e-12);
    const Eigen::Vector3d e(Uniform(random, -3.1, 3.1), Uniform(random, -1.57, 1.57), Uniform(random, -3.1, 3.1));
    EXPECT_LT(AngleBetween(FromYawPitchRoll(ToYawPitchRoll(FromYawPitchRoll(e))), FromYawPitchRoll(e)), 1e-9);
  }
}

TEST(AllowList, HoldsTheNetworksItNames) {
  const AllowList list("192.168.1.0/24, 10.0.0.7 ,fd00::/8");
  EXPECT_TRUE(list.Contains("192.168.1.200"));
  EXPECT_TRUE(list.Contains("::ffff:192.168.1.1"));
  EXPECT_FALSE(list.Contains("192.168.2.1"));
  EXPECT_TRUE(list.Contains("10.0.0.7"));
  EXPECT_FALSE(list.Contains("10.0.0.8"));
  EXPECT_TRUE(list.Contains("fd12::1"));
  EXPECT_FALSE(list.Contains("fe80::1"));
  EXPECT_FALSE(list.Contains("rubbish"));
  EXPECT_TRUE(AllowList("0.0.0.0/0").Contains("8.8.8.8"));
  EXPECT_TRUE(AllowList(" ").empty());
  for (const char* wrong : {"192.168.1.1/24", "192.168.1.0/33", "192.168.1", "10.0.0.0/", "10.0.0.0/-1", "fd00::1/8", "host.name"}) {
    EXPECT_THROW(AllowList{wrong}, std::invalid_argument) << wrong;
  }
}

Geon Cylinder(double radius, double half, const Eigen::Vector3d& at) {
  Geon geon;
  geon.type = GeonType::kCylinder;
  geon.size = {radius, radius, half};
  geon.X_TG = Pose::Translation(at);
  return geon;
}

TEST(FindGrasps, OpeningIsTheWidthAndFingersCloseOnOppositeSides) {
  const std::vector<Geon> parts = {Cylinder(0.02, 0.05, {0, 0, 0.05})};
  const std::vector<Grasp> grasps = FindGrasps(parts, 0);
  ASSERT_FALSE(grasps.empty());
  for (const Grasp& grasp : grasps) {
    EXPECT_NEAR(grasp.opening, 0.04, 0.004);
    EXPECT_GE(grasp.clearance, 0.004);
    EXPECT_GT(grasp.X_TH.translation().z(), 0.0);
    EXPECT_FALSE(grasp.reason.empty());
    EXPECT_NEAR(grasp.X_TH.matrix().col(0).z(), 0.0, 1e-9) << "closes across the cylinder";
  }
  EXPECT_TRUE(std::is_sorted(grasps.begin(), grasps.end(), [](const Grasp& a, const Grasp& b) { return a.quality > b.quality; }));
}

TEST(FindGrasps, WhatIsTooWideOrHiddenHasNone) {
  EXPECT_TRUE(FindGrasps({Cylinder(0.05, 0.06, {0, 0, 0.06})}, 0).empty());
  // A post in a ring of posts that leave no room for a finger.
  std::vector<Geon> parts = {Cylinder(0.01, 0.03, {0, 0, 0.03})};
  for (int i = 0; i < 8; ++i) {
    const double angle = i * kPi / 4;
    parts.push_back(Cylinder(0.01, 0.08, {0.027 * std::cos(angle), 0.027 * std::sin(angle), 0.08}));
  }
  EXPECT_TRUE(FindGrasps(parts, 0).empty());
  EXPECT_THROW(FindGrasps(parts, 9), std::invalid_argument);
}

TEST(FindGrasps, TurnsWithTheObject) {
  const Pose turn = Pose::Rotation(Eigen::Vector3d::UnitZ(), 0.8);
  Geon box = Cylinder(0.02, 0.04, {0.05, 0.0, 0.04});
  box.type = GeonType::kCuboid;
  Geon turned = box;
  turned.X_TG = turn * box.X_TG;
  const std::vector<Grasp> a = FindGrasps({box}, 0), b = FindGrasps({turned}, 0);
  ASSERT_FALSE(a.empty());
  ASSERT_EQ(a.size(), b.size());
  EXPECT_NEAR(a[0].quality, b[0].quality, 1e-6);
}

}  // namespace
}  // namespace geond::daemon
