// SPDX-License-Identifier: Apache-2.0
#include "daemon/scan_store.h"

#include <cmath>
#include <fstream>
#include <limits>

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "daemon/durable_file.h"
#include "daemon/exposure_file.h"
#include "tests/daemon/small_station.h"

namespace geond::daemon {
namespace {

Exposure SmallExposure(double angle) {
  Exposure exposure;
  exposure.image.columns = 5;
  exposure.image.rows = 3;
  for (int i = 0; i < 15; ++i) {
    exposure.image.depth.push_back(i % 4 == 0 ? std::numeric_limits<float>::quiet_NaN() : 0.4f + 0.01f * i);
  }
  exposure.table_angle = angle;
  exposure.timestamp = std::chrono::nanoseconds(123456789);
  return exposure;
}

bool SameBits(const Exposure& a, const Exposure& b) { return EncodeExposure(a) == EncodeExposure(b); }

TEST(ExposureFile, RoundTripsToTheBit) {
  const Exposure exposure = SmallExposure(1.25);
  const Exposure again = DecodeExposure(EncodeExposure(exposure), "x");
  EXPECT_TRUE(SameBits(again, exposure));
  EXPECT_EQ(again.table_angle, 1.25);
  EXPECT_EQ(again.timestamp, exposure.timestamp);
  EXPECT_TRUE(std::isnan(again.image.at(0, 0)));
}

TEST(ExposureFile, EveryCutAndEveryFlippedBitIsNoticed) {
  const std::string bytes = EncodeExposure(SmallExposure(0.5));
  for (std::size_t n = 0; n < bytes.size(); ++n) EXPECT_THROW(DecodeExposure(bytes.substr(0, n), "x"), FileError) << n;
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    std::string damaged = bytes;
    damaged[i] = static_cast<char>(damaged[i] ^ (1 << (i % 8)));
    EXPECT_THROW(DecodeExposure(damaged, "x"), FileError) << i;
  }
  EXPECT_THROW(DecodeExposure(bytes + "x", "x"), FileError);
}

TEST(DurableFile, ReplacesWholeOrNotAtAll) {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder.path() / "a";
  WriteDurably(path, "one");
  WriteDurably(path, "two");
  EXPECT_EQ(ReadWhole(path), "two");
  EXPECT_FALSE(std::filesystem::exists(path.string() + ".part"));
  EXPECT_THROW(WriteDurably(folder.path() / "absent" / "a", "x"), FileError);
  EXPECT_THROW(ReadWhole(folder.path() / "b"), FileError);
  EXPECT_THROW(ReadWhole(path, 2), FileError);
}

TEST(ScanStore, NumbersScansAndRemembersThem) {
  const TemporaryFolder folder;
  {
    ScanStore store(folder.path());
    EXPECT_TRUE(store.scans().empty());
    const ScanRecorder recorder = store.Begin(4, 0.25, "first \"one\"");
    EXPECT_EQ(store.scans().at(1).state, ScanState::kRunning);
    recorder.KeepView(0, SmallExposure(0.0));
    recorder.KeepView(1, SmallExposure(1.0));
    store.Begin(2, 0.0, "");
  }
  ScanStore again(folder.path());
  ASSERT_EQ(again.scans().size(), 2u);
  EXPECT_EQ(again.scans().at(1).state, ScanState::kInterrupted);
  EXPECT_EQ(again.scans().at(1).views, 4);
  EXPECT_EQ(again.scans().at(1).views_taken, 2);
  EXPECT_EQ(again.scans().at(1).label, "first \"one\"");
  EXPECT_DOUBLE_EQ(again.scans().at(1).first_angle, 0.25);
  again.Begin(1, 0.0, "");
  EXPECT_EQ(again.last_id(), 3);
}

TEST(ScanStore, ServesOnlyViewsThatAreWhole) {
  const TemporaryFolder folder;
  ScanStore store(folder.path());
  const ScanRecorder recorder = store.Begin(4, 0.0, "");
  for (int view = 0; view < 3; ++view) recorder.KeepView(view, SmallExposure(view));
  EXPECT_EQ(recorder.Views().size(), 3u);
  std::filesystem::resize_file(recorder.folder() / "view_001.exposure", 40);
  ASSERT_EQ(recorder.Views().size(), 1u);
  EXPECT_TRUE(SameBits(recorder.Views()[0], SmallExposure(0.0)));
}

TEST(ScanStore, FailedAndCancelledScansSayWhy) {
  const TemporaryFolder folder;
  ScanStore store(folder.path());
  store.Begin(4, 0.0, "").Abandon(ScanState::kFailed, "the laser is cold");
  store.Begin(4, 0.0, "").Abandon(ScanState::kCancelled, "");
  const ScanStore again(folder.path());
  EXPECT_EQ(again.scans().at(1).state, ScanState::kFailed);
  EXPECT_EQ(again.scans().at(1).error, "the laser is cold");
  EXPECT_EQ(again.scans().at(2).state, ScanState::kCancelled);
}

TEST(ScanStore, DeletedScansAreGoneAndTheirNumbersNotUsedAgain) {
  const TemporaryFolder folder;
  ScanStore store(folder.path());
  store.Begin(1, 0.0, "");
  store.Begin(1, 0.0, "");
  store.Delete(1);
  EXPECT_EQ(store.scans().count(1), 0u);
  EXPECT_FALSE(std::filesystem::exists(store.Folder(1)));
  store.Begin(1, 0.0, "");
  EXPECT_EQ(store.last_id(), 3);
}

TEST(ScanStore, ADamagedScanIsFailedNotFatal) {
  const TemporaryFolder folder;
  {
    ScanStore store(folder.path());
    store.Begin(1, 0.0, "");
    std::ofstream(store.Folder(1) / "journal.json") << "{ not json";
  }
  const ScanStore again(folder.path());
  EXPECT_EQ(again.scans().at(1).state, ScanState::kFailed);
  EXPECT_FALSE(again.scans().at(1).error.empty());
}

}  // namespace
}  // namespace geond::daemon
