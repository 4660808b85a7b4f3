// SPDX-License-Identifier: Apache-2.0
#include "daemon/scan_store.h"

#include <cmath>
#include <csignal>
#include <fstream>
#include <limits>

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "core/base/error.h"
#include "daemon/durable_file.h"
#include "daemon/exposure_file.h"
#include "tests/daemon/temporary_folder.h"

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
    EXPECT_EQ(store.count(), 0);
    EXPECT_EQ(store.newest(), 0);
    const ScanRecorder recorder = store.Begin(4, 0.25, "first \"one\"");
    EXPECT_EQ(store.Find(1)->state, ScanState::kRunning);
    recorder.KeepView(0, SmallExposure(0.0));
    recorder.KeepView(1, SmallExposure(1.0));
    store.Begin(2, 0.0, "");
  }
  ScanStore again(folder.path());
  ASSERT_EQ(again.count(), 2);
  EXPECT_EQ(again.Find(1)->state, ScanState::kInterrupted);
  EXPECT_EQ(again.Find(1)->views, 4);
  EXPECT_EQ(again.Find(1)->views_taken, 2);
  EXPECT_EQ(again.Find(1)->label, "first \"one\"");
  EXPECT_DOUBLE_EQ(again.Find(1)->first_angle, 0.25);
  again.Begin(1, 0.0, "");
  EXPECT_EQ(again.newest(), 3);
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
  {
    ScanStore store(folder.path());
    store.Begin(4, 0.0, "").Abandon(ScanState::kFailed, "the laser is cold");
    store.Begin(4, 0.0, "").Abandon(ScanState::kCancelled, "");
  }
  ScanStore again(folder.path());
  EXPECT_EQ(again.Find(1)->state, ScanState::kFailed);
  EXPECT_EQ(again.Find(1)->error, "the laser is cold");
  EXPECT_EQ(again.Find(2)->state, ScanState::kCancelled);
  again.Resume(1);
  EXPECT_EQ(again.Find(1)->state, ScanState::kRunning);
  EXPECT_EQ(again.Find(1)->error, "");
}

TEST(ScanStore, DeletedScansAreGoneAndTheirNumbersNeverUsedAgain) {
  const TemporaryFolder folder;
  {
    ScanStore store(folder.path());
    store.Begin(1, 0.0, "");
    store.Begin(1, 0.0, "");
    store.Delete(2);
    EXPECT_FALSE(store.Find(2));
    EXPECT_FALSE(std::filesystem::exists(store.Folder(2)));
    // What a crash leaves of one that is being deleted goes when the store is opened.
    EXPECT_TRUE(std::filesystem::exists(store.Discard(1)));
  }
  ScanStore again(folder.path());
  EXPECT_EQ(again.count(), 0);
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "000001.deleted"));
  again.Begin(1, 0.0, "");
  EXPECT_EQ(again.newest(), 3);
}

TEST(ScanStore, ADamagedScanIsFailedNotFatal) {
  const TemporaryFolder folder;
  {
    ScanStore store(folder.path());
    store.Begin(1, 0.0, "");
    std::ofstream(store.Folder(1) / "journal.json") << "{ not json";
  }
  const ScanStore again(folder.path());
  EXPECT_EQ(again.Find(1)->state, ScanState::kFailed);
  EXPECT_FALSE(again.Find(1)->error.empty());
}

TEST(ScanStore, OnlyOneProgramHasIt) {
  const TemporaryFolder folder;
  const ScanStore store(folder.path());
  EXPECT_THROW(ScanStore(folder.path()), FileError);
}

// A store with a done scan, as its files alone say, and one of each other kind.
void FillStore(const std::filesystem::path& folder) {
  ScanStore store(folder);
  WriteDurably(store.Begin(2, 0.0, "egg").folder() / "description.json",
               R"({"parts":[{"type":"ellipsoid"},{"type":"cuboid"}]})");
  store.Begin(4, 0.0, "").Abandon(ScanState::kFailed, "the laser is cold");
  store.Begin(4, 0.5, "").KeepView(0, SmallExposure(0.5));
  store.Pin(3, true);
}

std::vector<ScanSummary> AllOf(const std::filesystem::path& folder) { return ScanStore(folder).List(); }

TEST(ScanStore, TheIndexIsMadeAnewFromTheFolders) {
  const TemporaryFolder folder;
  FillStore(folder.path());
  const std::vector<ScanSummary> known = AllOf(folder.path());
  ASSERT_EQ(known.size(), 3u);
  EXPECT_EQ(known[2].types, (std::vector<std::string>{"ellipsoid", "cuboid"}));
  EXPECT_TRUE(known[0].pinned);
  const std::filesystem::path index = folder.path() / "index.sqlite";
  ASSERT_TRUE(std::filesystem::exists(index));

  std::filesystem::remove(index);
  EXPECT_EQ(AllOf(folder.path()), known) << "lost";
  WriteDurably(index,
               "this is no database, but a text that is long enough to be taken for the head of one, or so it hopes");
  EXPECT_EQ(AllOf(folder.path()), known) << "replaced by something else";
  const std::string whole = ReadWhole(index);
  for (std::size_t n = 0; n < whole.size(); n += 509) {
    WriteDurably(index, whole.substr(0, n));
    EXPECT_EQ(AllOf(folder.path()), known) << "cut at byte " << n;
  }
  for (std::size_t i = 1; i < whole.size(); i += 811) {
    std::string damaged = whole;
    damaged.replace(i, std::min<std::size_t>(64, whole.size() - i), std::min<std::size_t>(64, whole.size() - i),
                    '\xa5');
    WriteDurably(index, damaged);
    const ScanStore store(folder.path());
    EXPECT_EQ(store.Find(1)->state, ScanState::kDone) << "damaged at byte " << i;
  }
}

TEST(ScanIndex, IsKeptInMemoryWhereNothingCanBeWritten) {
  ScanIndex index("/proc/index.sqlite");
  EXPECT_FALSE(index.durable());
  ScanSummary scan;
  scan.id = 5;
  scan.label = "a 'quoted' one; DROP TABLE scans";
  index.Put(scan);
  EXPECT_EQ(index.Find(5), scan);
  index.Remove(5);
  EXPECT_FALSE(index.Find(5));
  EXPECT_EQ(index.GreatestEver(), 5);
}

TEST(ScanStore, WhatFoldersSayOverrulesTheIndex) {
  const TemporaryFolder folder;
  FillStore(folder.path());
  // As after a crash between folder and index, or a person with a file manager.
  WriteDurably(folder.path() / "000002/description.json", R"({"parts":[{"type":"cylinder"}]})");
  std::filesystem::remove(folder.path() / "000001/description.json");
  std::filesystem::rename(folder.path() / "000003", folder.path() / "000007");
  const ScanStore store(folder.path());
  EXPECT_EQ(store.Find(1)->state, ScanState::kInterrupted);
  EXPECT_EQ(store.Find(2)->state, ScanState::kDone);
  EXPECT_FALSE(store.Find(3));
  EXPECT_EQ(store.Find(7)->views_taken, 1);
  EXPECT_EQ(store.newest_done(), 2);
}

TEST(ScanStore, ListsByCursorAndByState) {
  const TemporaryFolder folder;
  ScanStore store(folder.path());
  for (int i = 1; i <= 7; ++i) {
    store.Begin(1, 0.0, "");
    if (i % 2 == 0) WriteDurably(store.Folder(i) / "description.json", R"({"parts":[]})");
    store.Refresh(i);
  }
  const auto ids = [](const std::vector<ScanSummary>& scans) {
    std::vector<int> numbers;
    for (const ScanSummary& scan : scans) numbers.push_back(scan.id);
    return numbers;
  };
  EXPECT_EQ(ids(store.List({0, 3, false})), (std::vector<int>{7, 6, 5}));
  EXPECT_EQ(ids(store.List({5, 3, false})), (std::vector<int>{4, 3, 2}));
  EXPECT_EQ(ids(store.List({0, 10, true})), (std::vector<int>{6, 4, 2}));
  EXPECT_EQ(ids(store.List({1, 10, false})), std::vector<int>{});
}

TEST(ScanStore, RemovesByAgeAndSizeButNotWhatIsPinnedOrNewest) {
  using namespace std::chrono_literals;
  const TemporaryFolder folder;
  ScanStore store(folder.path());
  for (int i = 1; i <= 5; ++i) {
    const ScanRecorder recorder = store.Begin(1, 0.0, "");
    WriteDurably(recorder.folder() / "filling", std::string(10000, 'x'));
    WriteDurably(recorder.folder() / "description.json", R"({"parts":[]})");
    store.Refresh(i);
  }
  store.Begin(1, 0.0, "");  // runs
  store.Pin(2, true);
  const auto now = std::chrono::system_clock::now();
  EXPECT_EQ(store.Expired(now + 100000h), std::vector<int>{}) << "no limits";
  store.SetLimits({24h, 0, 0});
  EXPECT_EQ(store.Expired(now + 23h), std::vector<int>{});
  EXPECT_EQ(store.Expired(now + 25h), (std::vector<int>{1, 3, 4})) << "2 is pinned, 5 the newest description, 6 runs";
  EXPECT_EQ(store.Expired(now - 100000h), std::vector<int>{}) << "a clock that went back";
  store.SetLimits({0h, 40000, 0});
  EXPECT_EQ(store.Expired(now), (std::vector<int>{1, 3}));
  for (const int id : store.Expired(now)) store.Delete(id);
  EXPECT_EQ(store.Expired(now), std::vector<int>{});
  EXPECT_LE(store.bytes(), 40000u);
}

TEST(ScanStore, BeginsNoScanOnADiskThatIsNearlyFull) {
  const TemporaryFolder folder;
  ScanStore store(folder.path(), {std::chrono::hours(0), 0, std::uint64_t{1} << 62});
  try {
    store.Begin(1, 0.0, "");
    FAIL() << "it began";
  } catch (const FileError& error) {
    EXPECT_NE(std::string(error.what()).find("MB left"), std::string::npos) << error.what();
    EXPECT_NE(error.remedy().find("store.min_free_mb"), std::string::npos);
  }
  EXPECT_EQ(store.count(), 0);
}

// In a process of its own, because the limit cannot be lifted again.
TEST(ScanStore, AFullDiskIsAnErrorThatSaysSoAndLosesNothing) {
  const TemporaryFolder folder;
  const pid_t child = fork();
  if (child == 0) {
    std::signal(SIGXFSZ, SIG_IGN);
    ScanStore store(folder.path());
    const ScanRecorder recorder = store.Begin(3, 0.0, "");
    recorder.KeepView(0, SmallExposure(0.0));
    const rlimit limit{60, 60};
    setrlimit(RLIMIT_FSIZE, &limit);
    try {
      recorder.KeepView(1, SmallExposure(1.0));
      _exit(1);
    } catch (const FileError& error) {
      if (error.cause() != "File too large" || error.call() != "write") _exit(2);
    }
    if (std::filesystem::exists(recorder.folder() / "view_001.exposure")) _exit(3);
    if (std::filesystem::exists(recorder.folder() / "view_001.exposure.part")) _exit(4);
    if (recorder.Views().size() != 1) _exit(5);
    try {
      store.Begin(1, 0.0, "the index and the journal have no room either");
      _exit(6);
    } catch (const FileError&) {
    }
    _exit(0);
  }
  int status = 0;
  waitpid(child, &status, 0);
  EXPECT_EQ(WIFEXITED(status) ? WEXITSTATUS(status) : -1, 0);
  const ScanStore again(folder.path());
  EXPECT_EQ(again.count(), 1);
  EXPECT_EQ(again.Find(1)->views_taken, 1);
}

}  // namespace
}  // namespace geond::daemon
