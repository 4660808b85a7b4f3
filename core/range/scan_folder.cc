// SPDX-License-Identifier: Apache-2.0
#include "core/range/scan_folder.h"

#include <openssl/evp.h>

#include <cmath>
#include <fstream>
#include <stdexcept>

#include "core/base/error.h"
#include "core/base/printed.h"
#include "core/range/scan_json.h"

namespace geond {
namespace {

namespace fs = std::filesystem;

constexpr std::uintmax_t kMaxJsonBytes = 64u << 20;
// A float image at its largest, or the PNG of noise of that size.
constexpr std::uintmax_t kMaxImageBytes = 4 * kMaxImagePixels + (1u << 20);
constexpr double kDepthTolerance = 1e-6;  // m: a PNG may lose so much

std::string Sha256(const std::vector<std::uint8_t>& bytes) {
  unsigned char sum[EVP_MAX_MD_SIZE];
  unsigned int n = 0;
  if (EVP_Digest(bytes.data(), bytes.size(), sum, &n, EVP_sha256(), nullptr) != 1) {
    throw std::runtime_error("SHA-256 is not available in the OpenSSL library");
  }
  std::string text;
  for (unsigned int i = 0; i < n; ++i) {
    constexpr char kDigits[] = "0123456789abcdef";
    text += kDigits[sum[i] >> 4];
    text += kDigits[sum[i] & 15];
  }
  return text;
}

std::vector<std::uint8_t> ReadFile(const fs::path& path, std::uintmax_t max_bytes) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (!fs::exists(status)) throw FileError(path.string(), "open", "there is no such file");
  if (!fs::is_regular_file(status)) throw FileError(path.string(), "open", "it is no plain file");
  const std::uintmax_t size = fs::file_size(path, error);
  if (error) throw FileError(path.string(), "open", error.message());
  if (size > max_bytes) {
    throw FileError(path.string(), "read", "it has " + std::to_string(size) + " bytes, more than such a file can have");
  }
  std::ifstream file(path, std::ios::binary);
  if (!file) throw FileError(path.string(), "open", "it cannot be opened", "Check the permissions");
  std::vector<std::uint8_t> bytes(size);
  file.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(size));
  if (static_cast<std::uintmax_t>(file.gcount()) != size) {
    throw FileError(path.string(), "read",
                    "it ended at byte " + std::to_string(file.gcount()) + " of " + std::to_string(size));
  }
  return bytes;
}

void WriteFile(const fs::path& path, const std::vector<std::uint8_t>& bytes) {
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  file.close();
  if (!file) throw FileError(path.string(), "write", "the file cannot be written", "Check permissions and free space");
}

std::vector<std::uint8_t> ToBytes(const std::string& text) { return {text.begin(), text.end()}; }

std::vector<std::uint8_t> ReadChecked(const fs::path& path, const std::string& sha256) {
  std::vector<std::uint8_t> bytes = ReadFile(path, kMaxImageBytes);
  if (Sha256(bytes) != sha256) {
    throw FileError(path.string(), "check", "its SHA-256 is not the one in scan.json: the file was damaged or changed",
                    "Copy it again from where it came");
  }
  return bytes;
}

bool UsePng(const RecordedScan::View& view, ScanImageFormat format) {
  if (format != ScanImageFormat::kAuto) return format == ScanImageFormat::kPng;
  return FinestDepthCode(view.exposure.image).scale / 2.0 <= kDepthTolerance;
}

void CheckScan(const RecordedScan& scan) {
  for (std::size_t i = 0; i < scan.views.size(); ++i) {
    const RangeImage& image = scan.views[i].exposure.image;
    const SensorModel& sensor = scan.views[i].sensor;
    const auto pixels = static_cast<std::int64_t>(image.columns) * image.rows;
    if (image.columns < 1 || image.rows < 1 || image.columns > kMaxImageSide || image.rows > kMaxImageSide ||
        pixels > kMaxImagePixels || static_cast<std::int64_t>(image.depth.size()) != pixels ||
        image.columns != sensor.columns || image.rows != sensor.rows) {
      throw std::invalid_argument("WriteScan: the image of view " + std::to_string(i) +
                                  " has not the size its sensor says, or not one depth a pixel");
    }
  }
}

}  // namespace

Pose SensorInTurntable(const StationGeometry& station, double table_angle) {
  const Pose X_WT = station.X_WT * Pose::Rotation(Eigen::Vector3d::UnitZ(), table_angle);
  return Inverse(X_WT) * station.X_WS;
}

RecordedScan ReadScan(const fs::path& folder) {
  std::error_code error;
  if (!fs::is_directory(folder, error)) {
    throw FileError(folder.string(), "open scan", "there is no such folder",
                    "A recorded scan is a folder with scan.json and its range images");
  }
  const fs::path json_path = folder / "scan.json";
  const std::vector<std::uint8_t> text = ReadFile(json_path, kMaxJsonBytes);
  ScanDocument document = ScanFromJson({text.begin(), text.end()}, json_path.string());
  for (std::size_t i = 0; i < document.images.size(); ++i) {
    const ScanImageEntry& entry = document.images[i];
    RecordedScan::View& view = document.scan.views[i];
    const fs::path path = folder / entry.file;
    const std::vector<std::uint8_t> bytes = ReadChecked(path, entry.sha256);
    view.exposure.image = entry.png
                              ? DecodeDepthPng(bytes, view.sensor.columns, view.sensor.rows, entry.code, path.string())
                              : DecodeDepthFloats(bytes, view.sensor.columns, view.sensor.rows, path.string());
  }
  if (document.truth_file) {
    const std::vector<std::uint8_t> truth = ReadChecked(folder / *document.truth_file, document.truth_sha256);
    document.scan.truth.assign(truth.begin(), truth.end());
  }
  return std::move(document.scan);
}

void WriteScan(const RecordedScan& scan, const fs::path& folder, ScanImageFormat format) {
  CheckScan(scan);
  const fs::path json_path = folder / "scan.json";
  std::error_code error;
  fs::create_directories(folder, error);
  if (!fs::is_directory(folder)) throw FileError(folder.string(), "create folder", error.message());
  fs::remove(json_path, error);  // from here on the folder is not whole
  if (error) throw FileError(json_path.string(), "replace", error.message());

  ScanDocument document;
  document.scan.station = scan.station;
  document.scan.has_table = scan.has_table;
  document.scan.calibration = scan.calibration;
  document.scan.seed = scan.seed;
  document.scan.software = scan.software;
  for (std::size_t i = 0; i < scan.views.size(); ++i) {
    const RecordedScan::View& view = scan.views[i];
    const RangeImage& image = view.exposure.image;
    ScanImageEntry entry;
    entry.png = UsePng(view, format);
    entry.file = Printed("view_%03zu.%s", i, entry.png ? "png" : "f32");
    if (entry.png) entry.code = FinestDepthCode(image);
    const std::vector<std::uint8_t> bytes = entry.png ? EncodeDepthPng(image, entry.code) : EncodeDepthFloats(image);
    entry.sha256 = Sha256(bytes);
    WriteFile(folder / entry.file, bytes);
    document.images.push_back(entry);
    document.scan.views.push_back(
        {{{}, view.exposure.table_angle, view.exposure.timestamp}, view.sensor, view.X_TS_measured, view.X_TS_refined});
  }
  if (!scan.truth.empty()) {
    document.truth_file = "truth.json";
    document.truth_sha256 = Sha256(ToBytes(scan.truth));
    WriteFile(folder / *document.truth_file, ToBytes(scan.truth));
  }
  const fs::path unfinished = folder / "scan.json.part";
  WriteFile(unfinished, ToBytes(ScanToJson(document)));
  fs::rename(unfinished, json_path, error);
  if (error) throw FileError(json_path.string(), "write", error.message());
}

}  // namespace geond
