// SPDX-License-Identifier: Apache-2.0
// The store through crashes at some of its writes; store_crash_validation goes through all of them.
#include <cstdlib>

#include <gtest/gtest.h>

#include "tests/daemon/temporary_folder.h"
#include "tests/system/store_lives.h"

namespace geond::system_test {
namespace {

class StoreCrash : public testing::Test {
 protected:
  StoreCrash() {
    const Life whole = Live(GEOND_STORE_CHILD, folder_.path() / "store", {});
    expected_ = whole.After("done");
    calls_ = std::atoi(whole.After("calls").c_str());
  }
  std::string Survives(const std::vector<Crash>& crashes) const {
    return Survive(GEOND_STORE_CHILD, folder_.path() / "store", crashes, expected_);
  }

  daemon::TemporaryFolder folder_;
  std::string expected_;
  int calls_ = 0;
};

TEST_F(StoreCrash, NothingAcknowledgedIsLostAtAnyWrite) {
  ASSERT_FALSE(expected_.empty());
  ASSERT_GT(calls_, 60) << "the disk sees too few calls to stand between the program and its files";
  int n = 0;
  for (int at = 1; at <= calls_; at += 11) {
    for (const char* loss : {"nothing", "all", "torn"}) {
      if (n++ % 3 == 0 || std::string(loss) == "torn") {
        EXPECT_EQ(Survives({{at, loss, static_cast<std::uint64_t>(at), -1}}), "")
            << loss << " at call " << at << " of " << calls_;
      }
    }
  }
}

TEST_F(StoreCrash, ASecondCrashDuringRecoveryLosesNothingEither) {
  ASSERT_FALSE(expected_.empty());
  for (int i = 0; i < 4; ++i) {
    const int at = calls_ * (i + 1) / 6, again = 3 + 9 * i;
    const auto seed = static_cast<std::uint64_t>(i + 1);
    EXPECT_EQ(Survives({{at, "torn", seed, -1}, {again, "torn", seed + 100, -1}}), "") << at << ", then " << again;
  }
}

}  // namespace
}  // namespace geond::system_test
