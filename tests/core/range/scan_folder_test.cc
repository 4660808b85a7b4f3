// SPDX-License-Identifier: Apache-2.0
#include "core/range/scan_folder.h"

#include <cmath>
#include <fstream>
#include <functional>
#include <limits>
#include <numbers>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/range/depth_image_file.h"
#include "core/range/scan_json.h"

namespace geond {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

constexpr double kDegree = std::numbers::pi / 180.0;

// A folder of its own for each test, gone afterwards.
class ScanFolder : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(testing::TempDir()) /
              (std::string("geond_scan_") + testing::UnitTest::GetInstance()->current_test_info()->name());
    fs::remove_all(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  std::string JsonText() const {
    std::ifstream file(folder_ / "scan.json");
    std::stringstream text;
    text << file.rdbuf();
    return text.str();
  }
  void SetJsonText(const std::string& text) const { std::ofstream(folder_ / "scan.json") << text; }

  std::string ReadFailure() const {
    try {
      ReadScan(folder_);
    } catch (const FileError& error) {
      return error.what();
    }
    return "no FileError";
  }

  fs::path folder_;
};

RangeImage Ramp(int columns, int rows, double near, double far) {
  RangeImage image{columns, rows, {}};
  for (int i = 0; i < columns * rows; ++i) {
    image.depth.push_back(i % 7 == 3 ? std::numeric_limits<float>::quiet_NaN()
                                     : static_cast<float>(near + (far - near) * std::fmod(i * 0.6180339887, 1.0)));
  }
  return image;
}

RecordedScan SampleScan() {
  RecordedScan scan;
  scan.station.sensor.columns = 24;
  scan.station.sensor.rows = 17;
  scan.station.sensor.focal_u = 521.25;
  scan.station.sensor.focal_v = 520.75;
  scan.station.sensor.center_u = 11.5;
  scan.station.sensor.center_v = 8.25;
  scan.station.sensor.min_depth = 0.2;
  scan.station.sensor.max_depth = 0.9;
  scan.station.sensor.depth_noise = 0.0003;
  scan.station.X_WS = Pose::Translation({0.0, -0.42, 0.21}) * Pose::Rotation({1, 0.1, 0.2}, -1.9);
  scan.station.X_WT = Pose::Translation({0.01, 0.02, 0.03}) * Pose::Rotation({1, 0, 0}, 0.01);
  scan.station.object_radius = 0.11;
  scan.station.object_height = 0.3;
  scan.station.table_clearance = 0.0015;
  scan.seed = 18446744073709551615ull;
  scan.software = "geond 0.1.0";
  scan.truth = "{\"parts\": [ 1.0, 2 ]}";
  for (int i = 0; i < 3; ++i) {
    RecordedScan::View view;
    view.exposure.image = Ramp(24, 17, 0.40, i == 1 ? 0.85 : 0.50);  // the second too deep for a PNG
    view.exposure.table_angle = 90.0 * i * kDegree;
    view.exposure.timestamp = std::chrono::nanoseconds(1234567890123 + i);
    view.sensor = scan.station.sensor;
    view.X_TS_measured = SensorInTurntable(scan.station, view.exposure.table_angle);
    if (i > 0) view.X_TS_refined = Pose::Rotation({0, 0, 1}, 0.001 * i) * view.X_TS_measured;
    scan.views.push_back(view);
  }
  scan.views[2].sensor.projection = SensorModel::Projection::kOrthographic;
  scan.views[2].sensor.focal_u = 1000.0;
  return scan;
}

void ExpectSame(const Pose& a, const Pose& b) {
  EXPECT_LT((a.translation() - b.translation()).norm(), 1e-14);
  EXPECT_LT(a.rotation().angularDistance(b.rotation()), 1e-7);
}

TEST(SensorInTurntable, TurnsTheSensorBackwards) {
  const StationGeometry station = SampleScan().station;
  for (double angle : {0.0, 0.3, -2.0, 7.0}) {
    // A point fixed to the table, seen from the sensor, two ways.
    const Eigen::Vector3d p_T(0.03, -0.02, 0.05);
    const Eigen::Vector3d p_W = station.X_WT * (Pose::Rotation({0, 0, 1}, angle) * p_T);
    const Eigen::Vector3d p_S = Inverse(station.X_WS) * p_W;
    EXPECT_LT((SensorInTurntable(station, angle) * p_S - p_T).norm(), 1e-14);
  }
}

TEST_F(ScanFolder, KeepsEverything) {
  const RecordedScan written = SampleScan();
  WriteScan(written, folder_);
  EXPECT_TRUE(fs::exists(folder_ / "view_000.png"));
  EXPECT_TRUE(fs::exists(folder_ / "view_001.f32"));
  const RecordedScan read = ReadScan(folder_);
  EXPECT_EQ(read.seed, written.seed);
  EXPECT_EQ(read.software, written.software);
  EXPECT_EQ(read.truth, written.truth);
  EXPECT_EQ(read.has_table, written.has_table);
  EXPECT_EQ(read.station.sensor.focal_u, written.station.sensor.focal_u);
  EXPECT_NEAR(read.station.sensor.depth_noise, written.station.sensor.depth_noise, 1e-18);
  EXPECT_NEAR(read.station.table_clearance, written.station.table_clearance, 1e-18);
  EXPECT_NEAR(read.station.object_radius, written.station.object_radius, 1e-16);
  ExpectSame(read.station.X_WS, written.station.X_WS);
  ExpectSame(read.station.X_WT, written.station.X_WT);
  ASSERT_EQ(read.views.size(), written.views.size());
  for (std::size_t i = 0; i < read.views.size(); ++i) {
    const RecordedScan::View& a = read.views[i];
    const RecordedScan::View& b = written.views[i];
    EXPECT_NEAR(a.exposure.table_angle, b.exposure.table_angle, 1e-15);
    EXPECT_EQ(a.exposure.timestamp, b.exposure.timestamp);
    EXPECT_EQ(a.sensor.projection, b.sensor.projection);
    EXPECT_EQ(a.sensor.focal_u, b.sensor.focal_u);
    ExpectSame(a.X_TS_measured, b.X_TS_measured);
    ASSERT_EQ(a.X_TS_refined.has_value(), b.X_TS_refined.has_value());
    if (a.X_TS_refined) ExpectSame(*a.X_TS_refined, *b.X_TS_refined);
    ASSERT_EQ(a.exposure.image.columns, 24);
    ASSERT_EQ(a.exposure.image.rows, 17);
    for (std::size_t k = 0; k < b.exposure.image.depth.size(); ++k) {
      const float x = a.exposure.image.depth[k], y = b.exposure.image.depth[k];
      ASSERT_EQ(std::isnan(x), std::isnan(y));
      if (std::isnan(x)) continue;
      ASSERT_LE(std::abs(x - y), 1e-6) << "view " << i << " pixel " << k;
    }
  }
}

TEST_F(ScanFolder, ReadingAndWritingAgainChangesNothing) {
  WriteScan(SampleScan(), folder_);
  const std::string first = JsonText();
  const RecordedScan once = ReadScan(folder_);
  WriteScan(once, folder_);
  WriteScan(ReadScan(folder_), folder_);
  const RecordedScan thrice = ReadScan(folder_);
  for (std::size_t i = 0; i < once.views.size(); ++i) {
    for (std::size_t k = 0; k < once.views[i].exposure.image.depth.size(); ++k) {
      const float x = once.views[i].exposure.image.depth[k], y = thrice.views[i].exposure.image.depth[k];
      if (std::isnan(x)) continue;
      ASSERT_NEAR(x, y, 1e-6);
    }
  }
  EXPECT_THAT(first, HasSubstr("\"angle_deg\""));
  EXPECT_THAT(first, HasSubstr("\"position_mm\""));
}

TEST_F(ScanFolder, FloatsKeepEveryBit) {
  WriteScan(SampleScan(), folder_, ScanImageFormat::kFloat);
  const RecordedScan read = ReadScan(folder_), written = SampleScan();
  for (std::size_t i = 0; i < read.views.size(); ++i) {
    const auto& a = read.views[i].exposure.image.depth;
    const auto& b = written.views[i].exposure.image.depth;
    for (std::size_t k = 0; k < a.size(); ++k) ASSERT_TRUE(a[k] == b[k] || (std::isnan(a[k]) && std::isnan(b[k])));
  }
}

TEST_F(ScanFolder, PngErrorIsAtMostHalfAStep) {
  WriteScan(SampleScan(), folder_, ScanImageFormat::kPng);
  const RecordedScan read = ReadScan(folder_), written = SampleScan();
  for (std::size_t i = 0; i < read.views.size(); ++i) {
    const auto& a = read.views[i].exposure.image.depth;
    const auto& b = written.views[i].exposure.image.depth;
    for (std::size_t k = 0; k < a.size(); ++k) {
      if (std::isnan(b[k])) continue;
      ASSERT_LE(std::abs(a[k] - b[k]), 8e-6 * 0.45 + 6e-8);
    }
  }
}

TEST_F(ScanFolder, HoldsImagesWithoutAnyReturn) {
  RecordedScan scan = SampleScan();
  for (float& z : scan.views[0].exposure.image.depth) z = std::numeric_limits<float>::quiet_NaN();
  WriteScan(scan, folder_);
  const RecordedScan read = ReadScan(folder_);
  for (float z : read.views[0].exposure.image.depth) EXPECT_TRUE(std::isnan(z));
}

TEST_F(ScanFolder, SaysWhatIsMissing) {
  EXPECT_THAT(ReadFailure(), HasSubstr("no such folder"));
  fs::create_directories(folder_);
  EXPECT_THAT(ReadFailure(), HasSubstr("scan.json"));
  WriteScan(SampleScan(), folder_);
  fs::remove(folder_ / "view_001.f32");
  EXPECT_THAT(ReadFailure(), HasSubstr("view_001.f32"));
}

TEST_F(ScanFolder, NoticesAChangedFile) {
  WriteScan(SampleScan(), folder_);
  for (const char* name : {"view_000.png", "view_001.f32", "truth.json"}) {
    WriteScan(SampleScan(), folder_);
    std::fstream file(folder_ / name, std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(10);
    file.put('\x5a');
    file.close();
    EXPECT_THAT(ReadFailure(), testing::AllOf(HasSubstr(name), HasSubstr("SHA-256")));
  }
}

// Each line: a text in scan.json, what takes its place (the first time it stands there), and what the error must name.
struct Damage {
  const char* from;
  const char* to;
  const char* named;
};

TEST_F(ScanFolder, NamesTheKeyThatIsWrong) {
  const Damage damages[] = {
      {"\"geond scan\"", "\"other\"", "key format:"},
      {"\"format_version\": 1", "\"format_version\": 99", "format_version"},
      {"\"has_table\": true", "\"has_table\": 1", "has_table"},
      {"\"seed\": 18446744073709551615", "\"seed\": -4", "seed"},
      {"\"software\"", "\"hardware\"", "software"},
      {"\"station\"", "\"station_\"", "station"},
      {"\"perspective\"", "\"fish-eye\"", "station.sensor.projection"},
      {"\"columns\": 24", "\"columns\": 0", "station.sensor.columns"},
      {"\"columns\": 24", "\"columns\": 24.5", "station.sensor.columns"},
      {"\"rows\": 17", "\"rows\": 4000000000000", "station.sensor.rows"},
      {"\"columns\": 24", "\"columns\": 30000", "view_000.png"},
      {"\"focal_u_px\": 521.25", "\"focal_u_px\": 0", "station.sensor.focal_u_px"},
      {"\"focal_u_px\": 521.25", "\"focal_u_px\": \"521\"", "station.sensor.focal_u_px"},
      {"\"max_depth_mm\": 900.0", "\"max_depth_mm\": 100.0", "station.sensor.max_depth_mm"},
      {"\"depth_noise_mm\": 0.3", "\"depth_noise_mm\": -1", "station.sensor.depth_noise_mm"},
      {"\"w\": ", "\"w\": 1", "station.X_WS.quaternion"},
      {"\"position_mm\"", "\"position_m\"", "station.X_WS.position_mm"},
      {"\"angle_deg\": 0.0", "\"angle_deg\": null", "views[0].angle_deg"},
      {"\"angle_deg\": 0.0", "\"angle_rad\": 0.0", "views[0].angle_deg"},
      {"\"angle_deg\": 0.0", "\"angle_deg\": 1e300", "views[0].angle_deg"},
      {"\"angle_deg\": 0.0", "\"angle_deg\": 1e999", "parse"},
      {"\"timestamp_ns\": 1234567890123", "\"timestamp_ns\": -1", "views[0].timestamp_ns"},
      {"\"timestamp_ns\": 1234567890123", "\"timestamp_ns\": 18446744073709551615", "views[0].timestamp_ns"},
      {"\"X_TS_measured\"", "\"X_TS\"", "views[0].X_TS_measured"},
      {"\"file\": \"view_000.png\"", "\"file\": \"../view_000.png\"", "views[0].image.file"},
      {"\"file\": \"view_000.png\"", "\"file\": \"\"", "views[0].image.file"},
      {"\"file\": \"view_001.f32\"", "\"file\": \"view_000.png\"", "views[1].image.file"},
      {"\"png16\"", "\"jpeg\"", "views[0].image.format"},
      {"\"png16\"", "\"float32\"", "view_000.png"},
      {"\"float32\"", "\"png16\"", "views[1].image.scale_mm"},
      {"\"scale_mm\": ", "\"scale_mm\": -", "views[0].image.scale_mm"},
      {"\"sha256\": \"", "\"sha256\": \"x", "truth.sha256"},
      {"\"views\": [", "\"views\": 3, \"others\": [", "views"},
      {"{", "[", "parse"},
      {"\"views\"", "\"views", "parse"},
  };
  WriteScan(SampleScan(), folder_);
  const std::string whole = JsonText();
  for (const Damage& damage : damages) {
    std::string text = whole;
    const std::size_t at = text.find(damage.from);
    ASSERT_NE(at, std::string::npos) << damage.from;
    SetJsonText(text.replace(at, std::string(damage.from).size(), damage.to));
    EXPECT_THAT(ReadFailure(), HasSubstr(damage.named)) << damage.from << " -> " << damage.to;
  }
}

TEST_F(ScanFolder, EveryTruncationOfScanJsonIsNoticed) {
  WriteScan(SampleScan(), folder_);
  const std::string whole = JsonText();
  for (std::size_t n = 0; n + 3 < whole.size(); n += 11) {
    EXPECT_THROW(ScanFromJson(whole.substr(0, n), "scan.json"), FileError) << n;
  }
}

TEST_F(ScanFolder, IsNotWholeUntilTheEnd) {
  RecordedScan scan = SampleScan();
  WriteScan(scan, folder_);
  fs::remove(folder_ / "view_001.f32");
  fs::create_directories(folder_ / "view_001.f32" / "in_the_way");
  EXPECT_THROW(WriteScan(scan, folder_), FileError);
  EXPECT_FALSE(fs::exists(folder_ / "scan.json"));
}

TEST_F(ScanFolder, RefusesAnImageOfAnotherSizeThanItsSensor) {
  RecordedScan scan = SampleScan();
  scan.views[1].exposure.image.rows = 16;
  EXPECT_THROW(WriteScan(scan, folder_), std::invalid_argument);
}

TEST(DepthPng, RefusesEveryTruncation) {
  const RangeImage image = Ramp(24, 17, 0.4, 0.5);
  const DepthCode code = FinestDepthCode(image);
  const std::vector<std::uint8_t> bytes = EncodeDepthPng(image, code);
  for (std::size_t n = 0; n < bytes.size(); ++n) {
    EXPECT_THROW(DecodeDepthPng(std::span(bytes).first(n), 24, 17, code, "cut.png"), FileError) << n;
  }
  EXPECT_THROW(DecodeDepthPng(bytes, 17, 24, code, "turned.png"), FileError);
}

}  // namespace
}  // namespace geond
