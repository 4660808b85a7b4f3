// SPDX-License-Identifier: Apache-2.0
#include "daemon/robot/robot_protocol.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "core/base/printed.h"
#include "daemon/robot/orientation.h"

namespace geond::daemon {
namespace {

constexpr double kDegrees = 180.0 / std::numbers::pi;

// A number that fits its columns whatever it is: controllers read neither "nan" nor "inf", and "-0.000" confuses people.
double Tame(double value, double limit, double least) {
  if (!std::isfinite(value)) return 0.0;
  value = std::clamp(value, -limit, limit);
  return std::abs(value) < least ? 0.0 : value;
}

struct Fields {
  int status, type, remaining, scan;
  Eigen::Vector3d position_mm, size_mm;
  double taper, bend_per_mm, confidence, age;
};

Fields FieldsOf(const RobotRecord& record) {
  Fields f{static_cast<int>(record.status), std::clamp(record.type, 0, 9), std::clamp(record.remaining, 0, 999),
           std::clamp(record.scan, 0, 999999), {}, {}, Tame(record.taper, 1.0, 5e-4), Tame(1e-3 * record.bend, 9.0, 5e-6),
           Tame(record.confidence, 1.0, 5e-3), Tame(record.age, 999999.0, 0.05)};
  for (int i = 0; i < 3; ++i) {
    f.position_mm[i] = Tame(1e3 * record.X_RG.translation()[i], 9999.0, 5e-4);
    f.size_mm[i] = Tame(1e3 * record.size[i], 9999.0, 5e-3);
  }
  return f;
}

std::string Ur(const RobotRecord& record) {
  const Fields f = FieldsOf(record);
  Eigen::Vector3d p = 1e-3 * f.position_mm, v = ToRotationVector(record.X_RG.rotation());
  for (int i = 0; i < 3; ++i) v[i] = Tame(v[i], 10.0, 5e-8);
  const Eigen::Vector3d size = 1e-3 * f.size_mm;
  return Printed("(%d,%d,%d,%.7f,%.7f,%.7f,%.7f,%.7f,%.7f,%.5f,%.5f,%.5f,%.3f,%.4f,%.3f,%.1f)", f.status, f.type, f.remaining,
               p.x(), p.y(), p.z(), v.x(), v.y(), v.z(), size.x(), size.y(), size.z(), f.taper, 1e3 * f.bend_per_mm,
               f.confidence, f.age);
}

std::string AbbPose(const RobotRecord& record) {
  const Fields f = FieldsOf(record);
  Eigen::Quaterniond q = record.X_RG.rotation().normalized();
  if (q.w() < 0) q.coeffs() = -q.coeffs();
  std::array<double, 4> parts = {q.w(), q.x(), q.y(), q.z()};
  for (double& part : parts) part = Tame(part, 1.0, 5e-8);
  return Printed("[[%.3f,%.3f,%.3f],[%.7f,%.7f,%.7f,%.7f]]", f.position_mm.x(), f.position_mm.y(), f.position_mm.z(), parts[0],
               parts[1], parts[2], parts[3]);
}

std::string AbbRecord(const RobotRecord& record) {
  const Fields f = FieldsOf(record);
  return Printed("[%d,%d,%d,%.2f,%.2f,%.2f,%.3f,%.5f,%.2f,%.0f,%d]", f.status, f.type, f.remaining, f.size_mm.x(), f.size_mm.y(),
               f.size_mm.z(), f.taper, f.bend_per_mm, f.confidence, f.age, f.scan);
}

std::string Kuka(const RobotRecord& record) {
  const Fields f = FieldsOf(record);
  Eigen::Vector3d abc = kDegrees * ToYawPitchRoll(record.X_RG.rotation());
  for (int i = 0; i < 3; ++i) abc[i] = Tame(abc[i], 360.0, 5e-6);
  return Printed("<Geon Status=\"%d\" Type=\"%d\" Remaining=\"%d\" Scan=\"%d\">", f.status, f.type, f.remaining, f.scan) +
         Printed("<Pose X=\"%.4f\" Y=\"%.4f\" Z=\"%.4f\" A=\"%.6f\" B=\"%.6f\" C=\"%.6f\"/>", f.position_mm.x(),
               f.position_mm.y(), f.position_mm.z(), abc[0], abc[1], abc[2]) +
         Printed("<Size A=\"%.3f\" B=\"%.3f\" C=\"%.3f\" Taper=\"%.4f\" Bend=\"%.6f\"/>", f.size_mm.x(), f.size_mm.y(),
               f.size_mm.z(), f.taper, f.bend_per_mm) +
         Printed("<Trust Confidence=\"%.3f\" Age=\"%.1f\"/></Geon>", f.confidence, f.age);
}

std::string Fanuc(const RobotRecord& record) {
  const Fields f = FieldsOf(record);
  Eigen::Vector3d rpw = kDegrees * ToYawPitchRoll(record.X_RG.rotation());
  for (int i = 0; i < 3; ++i) rpw[i] = Tame(rpw[i], 360.0, 5e-6);
  return Printed("%11d%11d%11d", f.status, f.type, f.remaining) +
         Printed("%11.4f%11.4f%11.4f%11.6f%11.6f%11.6f", f.position_mm.x(), f.position_mm.y(), f.position_mm.z(), rpw[2], rpw[1],
               rpw[0]) +
         Printed("%11.3f%11.3f%11.3f%11.4f%11.6f%11.3f%11.1f%11d", f.size_mm.x(), f.size_mm.y(), f.size_mm.z(), f.taper,
               f.bend_per_mm, f.confidence, f.age, f.scan);
}

std::string Plain(const RobotRecord& record) {
  const Fields f = FieldsOf(record);
  Eigen::Quaterniond q = record.X_RG.rotation().normalized();
  if (q.w() < 0) q.coeffs() = -q.coeffs();
  return Printed("%d %d %d %.4f %.4f %.4f %.8f %.8f %.8f %.8f", f.status, f.type, f.remaining, f.position_mm.x(),
               f.position_mm.y(), f.position_mm.z(), q.w(), q.x(), q.y(), q.z()) +
         Printed(" %.3f %.3f %.3f %.4f %.6f %.3f %.1f %d", f.size_mm.x(), f.size_mm.y(), f.size_mm.z(), f.taper, f.bend_per_mm,
               f.confidence, f.age, f.scan);
}

std::string Upper(std::string_view text) {
  std::string upper(text);
  for (char& letter : upper) {
    if (letter >= 'a' && letter <= 'z') letter = static_cast<char>(letter - 'a' + 'A');
  }
  return upper;
}

// The next word of a line, which it loses.
std::string TakeWord(std::string_view& line) {
  const std::size_t begin = std::min(line.find_first_not_of(" \t"), line.size());
  const std::size_t end = std::min(line.find_first_of(" \t", begin), line.size());
  const std::string word = Upper(line.substr(begin, end - begin));
  line.remove_prefix(end);
  return word;
}

}  // namespace

std::optional<RobotDialect> RobotDialectFromName(std::string_view name) {
  const std::string upper = Upper(name);
  if (upper == "UR") return RobotDialect::kUr;
  if (upper == "ABB") return RobotDialect::kAbb;
  if (upper == "KUKA") return RobotDialect::kKuka;
  if (upper == "FANUC") return RobotDialect::kFanuc;
  if (upper == "PLAIN") return RobotDialect::kPlain;
  return std::nullopt;
}

bool HasPose(RobotVerb verb) { return verb == RobotVerb::kPose || verb == RobotVerb::kGrasp; }

std::optional<RobotRequest> ParseRobotRequest(std::string_view line) {
  struct Known {
    std::string_view word;
    RobotVerb verb;
    bool numbered;
  };
  static constexpr std::array kKnown = {Known{"SCAN", RobotVerb::kScan, false},   Known{"STATUS", RobotVerb::kStatus, false},
                                        Known{"OBJECT", RobotVerb::kObject, false}, Known{"PART", RobotVerb::kPart, true},
                                        Known{"POSE", RobotVerb::kPose, true},    Known{"GRASP", RobotVerb::kGrasp, true},
                                        Known{"STOP", RobotVerb::kStop, false}};
  if (line.size() > kMaxRobotLine) return std::nullopt;
  const std::string word = TakeWord(line);
  const auto known = std::find_if(kKnown.begin(), kKnown.end(), [&](const Known& k) { return k.word == word; });
  if (known == kKnown.end()) return std::nullopt;
  RobotRequest request{known->verb, 0};
  const std::string number = TakeWord(line);
  if (known->numbered) {
    if (number.empty() || number.size() > 3 || number.find_first_not_of("0123456789") != std::string::npos) return std::nullopt;
    request.number = std::stoi(number);
    if (request.number < 1) return std::nullopt;
  } else if (!number.empty()) {
    return std::nullopt;
  }
  if (!TakeWord(line).empty()) return std::nullopt;
  return request;
}

std::string RobotAnswer(RobotDialect dialect, const RobotRecord& record, bool with_pose) {
  switch (dialect) {
    case RobotDialect::kUr: return Ur(record);
    case RobotDialect::kAbb: return with_pose ? AbbPose(record) : AbbRecord(record);
    case RobotDialect::kKuka: return Kuka(record);
    case RobotDialect::kFanuc: return Fanuc(record);
    case RobotDialect::kPlain: return Plain(record);
  }
  return {};
}

}  // namespace geond::daemon
