// SPDX-License-Identifier: Apache-2.0
// Whatever lies in a scan's folder of the store (first byte 0 of three), in an archive that somebody wants taken in (1)
// or in an exposure (2).
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>

#include <unistd.h>

#include "core/base/error.h"
#include "daemon/exposure_file.h"
#include "daemon/scan_archive.h"
#include "daemon/scan_recorder.h"
#include "tests/fuzz/check.h"

namespace {

using namespace geond;
using namespace geond::daemon;

const std::filesystem::path& Folder() {
  static const std::filesystem::path folder = [] {
    std::string name = (std::filesystem::temp_directory_path() / "geond_fuzz_XXXXXX").string();
    return std::filesystem::path(mkdtemp(name.data()));
  }();
  return folder;
}

void Write(const std::filesystem::path& path, const std::string& text) {
  std::ofstream(path, std::ios::binary) << text;
}

// What lies in a scan's folder after whatever has happened to it.
void Stored(const std::string& text) {
  const std::filesystem::path folder = Folder() / "scan";
  std::filesystem::create_directory(folder);
  const std::size_t half = text.find('\n');
  Write(folder / "journal.json", text.substr(0, half));
  Write(folder / "description.json", half == std::string::npos ? text : text.substr(half + 1));
  const ScanSummary scan = ReadSummary(folder, 1);
  Check(scan.state == ScanState::kDone || scan.state == ScanState::kFailed);
}

// An archive that somebody wants taken in.
void Archive(const std::string& text) {
  Write(Folder() / "archive.zip", text);
  std::filesystem::remove_all(Folder() / "import");
  try {
    ReadScanArchive(Folder() / "archive.zip", Folder() / "import", {1 << 20, 16});
  } catch (const FileError&) {
    Check(!std::filesystem::exists(Folder() / "import"));
  }
}

void Exposed(const std::string& text) {
  try {
    Check(EncodeExposure(DecodeExposure(text, "fuzz")) == text);
  } catch (const FileError&) {
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::string text(reinterpret_cast<const char*>(data) + 1, size - 1);
  const int kind = data[0] % 3;
  kind == 0 ? Stored(text) : kind == 1 ? Archive(text) : Exposed(text);
  return 0;
}
