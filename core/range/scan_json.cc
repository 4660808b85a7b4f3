// SPDX-License-Identifier: Apache-2.0
#include "core/range/scan_json.h"

#include <cmath>
#include <numbers>
#include <set>
#include <sstream>

#include <nlohmann/json.hpp>

#include "core/base/error.h"

namespace geond {
namespace {

using nlohmann::json;
using nlohmann::ordered_json;

constexpr double kDegrees = 180.0 / std::numbers::pi;  // a radian
constexpr double kMillimetres = 1e3;                   // a metre
constexpr double kFarthest = 1e9;                      // mm: no station is larger

std::string Short(double value) {
  std::ostringstream text;
  text.precision(12);
  text << value;
  return text.str();
}

// A value of a JSON file that knows where it stands, so that whatever is wrong with it is said as file and key
// ("views[3].angle_deg"). Every function throws FileError. The json must outlive it.
class JsonField {
 public:
  JsonField(const json& value, std::string file, std::string key = {})
      : json_(&value), file_(std::move(file)), key_(std::move(key)) {}

  bool Has(const std::string& name) const { return json_->is_object() && json_->contains(name); }
  JsonField operator[](const std::string& name) const;  // the member of an object
  JsonField operator[](std::size_t index) const;        // the entry of an array
  std::size_t ArraySize() const;
  void ExpectObject() const;

  double Number(double low, double high) const;  // low <= value <= high
  std::int64_t Integer(std::int64_t low, std::int64_t high) const;
  std::uint64_t Unsigned() const;
  bool Boolean() const;
  std::string Text() const;
  // {"position_mm": [x, y, z], "quaternion": {"w", "x", "y", "z"}}, the quaternion of length 1 to 1e-3.
  geond::Pose Pose() const;

  [[noreturn]] void Fail(const std::string& cause, const std::string& remedy = {}) const;

 private:
  const json* json_;
  std::string file_, key_;
};

JsonField JsonField::operator[](const std::string& name) const {
  ExpectObject();
  const auto found = json_->find(name);
  const std::string key = key_.empty() ? name : key_ + "." + name;
  if (found == json_->end()) throw FileError(file_, "read key " + key, "it is missing");
  return {*found, file_, key};
}

JsonField JsonField::operator[](std::size_t index) const {
  if (index >= ArraySize()) Fail("it has only " + std::to_string(ArraySize()) + " entries");
  return {(*json_)[index], file_, key_ + "[" + std::to_string(index) + "]"};
}

std::size_t JsonField::ArraySize() const {
  if (!json_->is_array()) Fail("an array is wanted, not " + std::string(json_->type_name()));
  return json_->size();
}

void JsonField::ExpectObject() const {
  if (!json_->is_object()) Fail("an object is wanted, not " + std::string(json_->type_name()));
}

double JsonField::Number(double low, double high) const {
  if (!json_->is_number()) Fail("a number is wanted, not " + std::string(json_->type_name()));
  const double value = json_->get<double>();
  if (!(value >= low && value <= high)) {
    Fail("the value is " + Short(value) + ", but must lie between " + Short(low) + " and " + Short(high));
  }
  return value;
}

std::int64_t JsonField::Integer(std::int64_t low, std::int64_t high) const {
  if (!json_->is_number_integer()) Fail("a whole number is wanted");
  if (json_->is_number_unsigned() && json_->get<std::uint64_t>() > static_cast<std::uint64_t>(INT64_MAX)) {
    Fail("the value is too large");
  }
  const auto value = json_->get<std::int64_t>();
  if (value < low || value > high) {
    Fail("the value is " + std::to_string(value) + ", but must lie between " + std::to_string(low) + " and " +
         std::to_string(high));
  }
  return value;
}

std::uint64_t JsonField::Unsigned() const {
  if (!json_->is_number_unsigned()) Fail("a whole number not below 0 is wanted");
  return json_->get<std::uint64_t>();
}

bool JsonField::Boolean() const {
  if (!json_->is_boolean()) Fail("true or false is wanted, not " + std::string(json_->type_name()));
  return json_->get<bool>();
}

std::string JsonField::Text() const {
  if (!json_->is_string()) Fail("a text is wanted, not " + std::string(json_->type_name()));
  return json_->get<std::string>();
}

geond::Pose JsonField::Pose() const {
  const JsonField position = (*this)["position_mm"], quaternion = (*this)["quaternion"];
  if (position.ArraySize() != 3) position.Fail("three numbers x, y, z are wanted");
  Eigen::Vector3d p;
  for (int i = 0; i < 3; ++i) p[i] = position[i].Number(-kFarthest, kFarthest) / kMillimetres;
  const Eigen::Quaterniond q(quaternion["w"].Number(-2, 2), quaternion["x"].Number(-2, 2),
                             quaternion["y"].Number(-2, 2), quaternion["z"].Number(-2, 2));
  if (std::abs(q.norm() - 1.0) > 1e-3) quaternion.Fail("its length is " + Short(q.norm()) + ", but must be 1");
  return {q, p};
}

void JsonField::Fail(const std::string& cause, const std::string& remedy) const {
  throw FileError(file_, key_.empty() ? "read" : "read key " + key_, cause, remedy);
}

ordered_json PoseToJson(const Pose& pose) {
  const Eigen::Vector3d p = pose.translation() * kMillimetres;
  const Eigen::Quaterniond& q = pose.rotation();
  return {{"position_mm", {p.x(), p.y(), p.z()}},
          {"quaternion", {{"w", q.w()}, {"x", q.x()}, {"y", q.y()}, {"z", q.z()}}}};
}

// --- sensor ---

ordered_json SensorToJson(const SensorModel& sensor) {
  const bool perspective = sensor.projection == SensorModel::Projection::kPerspective;
  const char* focal_u = perspective ? "focal_u_px" : "focal_u_px_per_m";
  const char* focal_v = perspective ? "focal_v_px" : "focal_v_px_per_m";
  return {{"projection", perspective ? "perspective" : "orthographic"},
          {"columns", sensor.columns},
          {"rows", sensor.rows},
          {focal_u, sensor.focal_u},
          {focal_v, sensor.focal_v},
          {"center_u_px", sensor.center_u},
          {"center_v_px", sensor.center_v},
          {"min_depth_mm", sensor.min_depth * kMillimetres},
          {"max_depth_mm", sensor.max_depth * kMillimetres},
          {"depth_noise_mm", sensor.depth_noise * kMillimetres}};
}

SensorModel SensorFrom(const JsonField& field) {
  SensorModel sensor;
  const std::string projection = field["projection"].Text();
  if (projection != "perspective" && projection != "orthographic") {
    field["projection"].Fail("it is \"" + projection + "\", but must be \"perspective\" or \"orthographic\"");
  }
  const bool perspective = projection == "perspective";
  sensor.projection = perspective ? SensorModel::Projection::kPerspective : SensorModel::Projection::kOrthographic;
  sensor.columns = static_cast<int>(field["columns"].Integer(1, kMaxImageSide));
  sensor.rows = static_cast<int>(field["rows"].Integer(1, kMaxImageSide));
  if (static_cast<std::int64_t>(sensor.columns) * sensor.rows > kMaxImagePixels) {
    field["rows"].Fail("columns times rows must not exceed " + std::to_string(kMaxImagePixels));
  }
  const auto focal = [&](const char* key) {
    const double value = field[key].Number(-1e9, 1e9);
    if (std::abs(value) < 1e-9) field[key].Fail("it must not be zero");
    return value;
  };
  sensor.focal_u = focal(perspective ? "focal_u_px" : "focal_u_px_per_m");
  sensor.focal_v = focal(perspective ? "focal_v_px" : "focal_v_px_per_m");
  sensor.center_u = field["center_u_px"].Number(-1e9, 1e9);
  sensor.center_v = field["center_v_px"].Number(-1e9, 1e9);
  sensor.min_depth = field["min_depth_mm"].Number(-kFarthest, kFarthest) / kMillimetres;
  sensor.max_depth = field["max_depth_mm"].Number(-kFarthest, kFarthest) / kMillimetres;
  if (!(sensor.min_depth < sensor.max_depth)) field["max_depth_mm"].Fail("it must be larger than min_depth_mm");
  sensor.depth_noise = field["depth_noise_mm"].Number(0, kFarthest) / kMillimetres;
  return sensor;
}

// --- files ---

// A name in the scan's own folder: no way out of it.
std::string FileNameFrom(const JsonField& field) {
  const std::string name = field.Text();
  if (name.empty() || name.size() > 200 || name[0] == '.' || name.find_first_of("/\\") != std::string::npos ||
      name.find('\0') != std::string::npos) {
    field.Fail("\"" + name.substr(0, 60) + "\" is no plain file name");
  }
  return name;
}

std::string Sha256From(const JsonField& field) {
  const std::string sum = field.Text();
  if (sum.size() != 64 || sum.find_first_not_of("0123456789abcdef") != std::string::npos) {
    field.Fail("64 hexadecimal digits are wanted");
  }
  return sum;
}

ordered_json ImageToJson(const ScanImageEntry& image) {
  ordered_json entry = {{"file", image.file}};
  if (image.png) {
    entry["format"] = "png16";
    entry["scale_mm"] = image.code.scale * kMillimetres;
    entry["offset_mm"] = image.code.offset * kMillimetres;
  } else {
    entry["format"] = "float32";
  }
  entry["sha256"] = image.sha256;
  return entry;
}

ScanImageEntry ImageFrom(const JsonField& field) {
  ScanImageEntry image;
  image.file = FileNameFrom(field["file"]);
  const std::string format = field["format"].Text();
  if (format != "png16" && format != "float32") {
    field["format"].Fail("it is \"" + format + "\", but must be \"png16\" or \"float32\"");
  }
  image.png = format == "png16";
  if (image.png) {
    image.code.scale = field["scale_mm"].Number(1e-9, kFarthest) / kMillimetres;
    image.code.offset = field["offset_mm"].Number(-kFarthest, kFarthest) / kMillimetres;
  }
  image.sha256 = Sha256From(field["sha256"]);
  return image;
}

// --- station and views ---

ordered_json StationToJson(const StationGeometry& station) {
  return {{"sensor", SensorToJson(station.sensor)},
          {"X_WS", PoseToJson(station.X_WS)},
          {"X_WT", PoseToJson(station.X_WT)},
          {"object_radius_mm", station.object_radius * kMillimetres},
          {"object_height_mm", station.object_height * kMillimetres},
          {"table_clearance_mm", station.table_clearance * kMillimetres}};
}

StationGeometry StationFrom(const JsonField& field) {
  StationGeometry station;
  station.sensor = SensorFrom(field["sensor"]);
  station.X_WS = field["X_WS"].Pose();
  station.X_WT = field["X_WT"].Pose();
  station.object_radius = field["object_radius_mm"].Number(0, kFarthest) / kMillimetres;
  station.object_height = field["object_height_mm"].Number(0, kFarthest) / kMillimetres;
  station.table_clearance = field["table_clearance_mm"].Number(-kFarthest, kFarthest) / kMillimetres;
  return station;
}

ordered_json CalibrationToJson(const UsedCalibration& calibration) {
  return {{"number", calibration.number},
          {"name", calibration.name},
          {"date", calibration.date},
          {"depth_scale", calibration.depth_scale},
          {"depth_offset_mm", calibration.depth_offset * kMillimetres}};
}

UsedCalibration CalibrationFrom(const JsonField& field) {
  UsedCalibration calibration;
  calibration.number = static_cast<int>(field["number"].Integer(0, 1'000'000'000));
  calibration.name = field["name"].Text();
  calibration.date = field["date"].Text();
  calibration.depth_scale = field["depth_scale"].Number(0.1, 10);
  calibration.depth_offset = field["depth_offset_mm"].Number(-kFarthest, kFarthest) / kMillimetres;
  return calibration;
}

RecordedScan::View ViewFrom(const JsonField& field, const SensorModel& station_sensor) {
  RecordedScan::View view;
  view.exposure.table_angle = field["angle_deg"].Number(-1e9, 1e9) / kDegrees;
  view.exposure.timestamp = std::chrono::nanoseconds(field["timestamp_ns"].Integer(0, INT64_MAX));
  view.sensor = field.Has("sensor") ? SensorFrom(field["sensor"]) : station_sensor;
  view.X_TS_measured = field["X_TS_measured"].Pose();
  if (field.Has("X_TS_refined")) view.X_TS_refined = field["X_TS_refined"].Pose();
  return view;
}

}  // namespace

std::string ScanToJson(const ScanDocument& document) {
  const RecordedScan& scan = document.scan;
  ordered_json root = {{"format", "geond scan"},      {"format_version", kScanFormatVersion},
                       {"software", scan.software},   {"seed", scan.seed},
                       {"has_table", scan.has_table}, {"station", StationToJson(scan.station)}};
  if (scan.calibration) root["calibration"] = CalibrationToJson(*scan.calibration);
  if (document.truth_file) root["truth"] = {{"file", *document.truth_file}, {"sha256", document.truth_sha256}};
  root["views"] = ordered_json::array();
  for (std::size_t i = 0; i < scan.views.size(); ++i) {
    const RecordedScan::View& view = scan.views[i];
    ordered_json entry = {{"angle_deg", view.exposure.table_angle * kDegrees},
                          {"timestamp_ns", view.exposure.timestamp.count()}};
    if (view.sensor != scan.station.sensor) entry["sensor"] = SensorToJson(view.sensor);
    entry["X_TS_measured"] = PoseToJson(view.X_TS_measured);
    if (view.X_TS_refined) entry["X_TS_refined"] = PoseToJson(*view.X_TS_refined);
    entry["image"] = ImageToJson(document.images[i]);
    root["views"].push_back(std::move(entry));
  }
  return root.dump(2, ' ', false, json::error_handler_t::replace) + "\n";
}

ScanDocument ScanFromJson(const std::string& text, const std::string& file) {
  json root;
  try {
    root = json::parse(text);
  } catch (const json::exception& error) {
    throw FileError(file, "parse", error.what());
  }
  const JsonField field(root, file);
  field.ExpectObject();
  if (field["format"].Text() != "geond scan") field["format"].Fail("it must be \"geond scan\"");
  field["format_version"].Integer(1, kScanFormatVersion);

  ScanDocument document;
  RecordedScan& scan = document.scan;
  scan.software = field["software"].Text();
  scan.seed = field["seed"].Unsigned();
  scan.has_table = field["has_table"].Boolean();
  scan.station = StationFrom(field["station"]);
  if (field.Has("calibration")) scan.calibration = CalibrationFrom(field["calibration"]);
  std::set<std::string> names;
  const auto expect_new = [&](const JsonField& at, const std::string& name) {
    if (!names.insert(name).second) at.Fail("the file " + name + " is named twice");
  };
  if (field.Has("truth")) {
    document.truth_file = FileNameFrom(field["truth"]["file"]);
    document.truth_sha256 = Sha256From(field["truth"]["sha256"]);
    expect_new(field["truth"]["file"], *document.truth_file);
  }
  const JsonField views = field["views"];
  for (std::size_t i = 0; i < views.ArraySize(); ++i) {
    scan.views.push_back(ViewFrom(views[i], scan.station.sensor));
    document.images.push_back(ImageFrom(views[i]["image"]));
    expect_new(views[i]["image"]["file"], document.images.back().file);
  }
  return document;
}

}  // namespace geond
