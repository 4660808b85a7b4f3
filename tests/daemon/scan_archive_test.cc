// SPDX-License-Identifier: Apache-2.0
#include "daemon/scan_archive.h"

#include <cmath>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <zip.h>

#include "core/base/error.h"
#include "daemon/durable_file.h"
#include "daemon/scan_recorder.h"
#include "tests/daemon/temporary_folder.h"

namespace geond::daemon {
namespace {

namespace fs = std::filesystem;

std::string What(const std::function<void()>& act) {
  try {
    act();
  } catch (const FileError& error) {
    return error.what();
  }
  return "no error";
}

// A recorded scan of one view with a description, as the store keeps it.
fs::path DoneScan(const TemporaryFolder& top) {
  const fs::path folder = top.path() / "000007";
  RecordedScan scan;
  scan.station.sensor.columns = 4;
  scan.station.sensor.rows = 3;
  RecordedScan::View view;
  view.sensor = scan.station.sensor;
  view.exposure.image.columns = 4;
  view.exposure.image.rows = 3;
  view.exposure.image.depth.assign(12, 0.45f);
  scan.views.push_back(view);
  WriteScan(scan, folder);
  ScanRecorder(folder).KeepPlan(1, 0.0, "egg");
  WriteDurably(folder / "description.json", R"({"parts":[{"type":"ellipsoid"}]})");
  ScanRecorder(folder).Pin(true);
  WriteDurably(folder / "cloud.ply", std::string(50000, 'p'));
  std::ofstream(folder / "mesh.ply.part") << "half";
  return folder;
}

// An archive of whatever names and contents.
void WriteZip(const fs::path& path, const std::vector<std::pair<std::string, std::string>>& files) {
  int code = 0;
  zip_t* archive = zip_open(path.c_str(), ZIP_CREATE | ZIP_TRUNCATE, &code);
  ASSERT_NE(archive, nullptr);
  for (const auto& [name, text] : files) {
    ASSERT_GE(
        zip_file_add(archive, name.c_str(), zip_source_buffer(archive, text.data(), text.size(), 0), ZIP_FL_OVERWRITE),
        0);
  }
  ASSERT_EQ(zip_close(archive), 0);
}

TEST(ScanArchive, RoundTripsAllFilesOfAScanButWhatIsItsPlacesOwn) {
  const TemporaryFolder top;
  const fs::path folder = DoneScan(top), zip = top.path() / "out/000007.zip", again = top.path() / "again";
  WriteScanArchive(folder, zip);
  EXPECT_LT(fs::file_size(zip), 5000u) << "packed";
  ReadScanArchive(zip, again);
  int files = 0;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    const fs::path name = entry.path().filename();
    const bool stays = name == "pinned" || name.extension() == ".part";
    EXPECT_EQ(fs::exists(again / name), !stays) << name;
    if (stays) continue;
    EXPECT_EQ(ReadWhole(again / name), ReadWhole(entry.path())) << name;
    ++files;
  }
  EXPECT_GE(files, 5);
  const ScanSummary scan = ReadSummary(again, 3);
  EXPECT_EQ(scan.state, ScanState::kDone);
  EXPECT_EQ(scan.label, "egg");
  EXPECT_FALSE(scan.pinned);
}

TEST(ScanArchive, RefusesWhatIsNoScan) {
  const TemporaryFolder top;
  const fs::path zip = top.path() / "x.zip", to = top.path() / "to";
  const std::string journal = R"({"views":1})";
  for (const char* name :
       {"../evil", "/etc/evil", "a/../../evil", "a/b/c", ".hidden", "a/.hidden", "x/view.part", "a\\b", "a b"}) {
    WriteZip(zip, {{"1/journal.json", journal}, {name, "x"}});
    EXPECT_THAT(What([&] { ReadScanArchive(zip, to); }), testing::HasSubstr("none of a scan's file")) << name;
    EXPECT_FALSE(fs::exists(to)) << name;
    EXPECT_FALSE(fs::exists(top.path() / "evil"));
  }
  WriteZip(zip, {{"1/other.json", "x"}});
  EXPECT_NE(What([&] { ReadScanArchive(zip, to); }), "no error");
  WriteZip(zip, {{"1/journal.json", "no json"}});
  EXPECT_NE(What([&] { ReadScanArchive(zip, to); }), "no error");
  WriteZip(zip, {{"1/journal.json", journal}, {"1/description.json", R"({"parts":[]})"}});
  EXPECT_THAT(What([&] { ReadScanArchive(zip, to); }), testing::HasSubstr("scan.json")) << "a description of no images";
  WriteZip(zip, {{"1/journal.json", journal}, {"1/big", std::string(1 << 20, 'x')}});
  EXPECT_THAT(What([&] { ReadScanArchive(zip, to, {1 << 16, 10}); }), testing::HasSubstr("unpacks to more"));
  EXPECT_THAT(What([&] { ReadScanArchive(zip, to, {1 << 24, 1}); }), testing::HasSubstr("has 2 files"));
  EXPECT_NE(What([&] { ReadScanArchive(top.path() / "absent.zip", to); }), "no error");
  EXPECT_FALSE(fs::exists(to));
}

TEST(ScanArchive, EveryCutAndManyDamagesAreNoticed) {
  const TemporaryFolder top;
  const fs::path folder = DoneScan(top), zip = top.path() / "a.zip", wrong = top.path() / "b.zip",
                 to = top.path() / "to";
  fs::remove(folder / "cloud.ply");
  WriteScanArchive(folder, zip);
  const std::string whole = ReadWhole(zip);
  for (std::size_t n = 0; n < whole.size(); n += 37) {
    WriteDurably(wrong, whole.substr(0, n));
    EXPECT_NE(What([&] { ReadScanArchive(wrong, to); }), "no error") << "cut at " << n;
  }
  // A damage may hit what nobody reads (a time, a comment); what is read must then be as it was.
  for (std::size_t i = 0; i < whole.size(); i += 29) {
    std::string damaged = whole;
    damaged[i] = static_cast<char>(damaged[i] ^ 0x41);
    WriteDurably(wrong, damaged);
    if (What([&] { ReadScanArchive(wrong, to); }) != "no error") continue;
    for (const fs::directory_entry& entry : fs::directory_iterator(to)) {
      const fs::path original = folder / entry.path().filename();
      if (fs::exists(original)) {
        EXPECT_EQ(ReadWhole(entry.path()), ReadWhole(original)) << "byte " << i;
      }
    }
  }
}

TEST(ScanArchive, CanBeStopped) {
  const TemporaryFolder top;
  const fs::path folder = DoneScan(top);
  std::stop_source stop;
  stop.request_stop();
  EXPECT_THROW(WriteScanArchive(folder, top.path() / "a.zip", stop.get_token()), Cancelled);
  EXPECT_FALSE(fs::exists(top.path() / "a.zip"));
}

}  // namespace
}  // namespace geond::daemon
