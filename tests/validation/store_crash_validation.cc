// SPDX-License-Identifier: Apache-2.0
// The store through crashes: at every call that changes the disk, with nothing, all or a torn part of the unsynced data
// lost; at random instants; and again during recovery. store_crash_validation [KILLS [SECOND_CRASHES [PASSES]]]
#include <cstdio>
#include <cstdlib>
#include <random>

#include "tests/daemon/temporary_folder.h"
#include "tests/system/store_lives.h"

int main(int argc, char** argv) {
  using namespace geond::system_test;
  const int kills = argc > 1 ? std::atoi(argv[1]) : 1000, seconds = argc > 2 ? std::atoi(argv[2]) : 200;
  const int passes = argc > 3 ? std::atoi(argv[3]) : 1;
  const geond::daemon::TemporaryFolder folder;
  const auto store = folder.path() / "store";
  const auto begin = std::chrono::steady_clock::now();
  const Life whole = Live(GEOND_STORE_CHILD, store, {});
  const double wall = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  const std::string expected = whole.After("done");
  const int calls = std::atoi(whole.After("calls").c_str());
  std::printf("a whole life: %d calls that change the disk, %.2f s\n", calls, wall);
  if (expected.empty()) return 1;
  int failures = 0;
  const auto count = [&](const std::string& wrong, const std::string& what) {
    if (wrong.empty()) return;
    ++failures;
    std::printf("  WRONG %s: %s\n", what.c_str(), wrong.c_str());
    std::fflush(stdout);
  };
  for (const char* loss : {"nothing", "all", "torn"}) {
    const int before = failures;
    int n = 0;
    for (int pass = 0; pass < passes; ++pass) {
      for (int at = 1; at <= calls; ++at, ++n) {
        count(
            Survive(GEOND_STORE_CHILD, store, {{at, loss, static_cast<std::uint64_t>(1000 * pass + at), -1}}, expected),
            std::string(loss) + " at call " + std::to_string(at));
      }
    }
    std::printf("loss %-8s at every one of %d calls: %d lives, %d wrong\n", loss, calls, n, failures - before);
    std::fflush(stdout);
  }
  std::mt19937_64 random(7);
  int before = failures;
  for (int i = 0; i < kills; ++i) {
    const int after = static_cast<int>(random() % static_cast<std::uint64_t>(1.1e6 * wall));
    count(Survive(GEOND_STORE_CHILD, store, {{0, "nothing", 1, after}}, expected),
          "kill after " + std::to_string(after) + " us");
  }
  std::printf("kill -9 at %d random instants: %d wrong\n", kills, failures - before);
  before = failures;
  for (int i = 0; i < seconds; ++i) {
    const int at = 1 + static_cast<int>(random() % static_cast<std::uint64_t>(calls)),
              again = 1 + static_cast<int>(random() % 60);
    count(Survive(GEOND_STORE_CHILD, store, {{at, "torn", random(), -1}, {again, "torn", random(), -1}}, expected),
          "torn at call " + std::to_string(at) + ", again at " + std::to_string(again));
  }
  std::printf("a second crash during recovery, %d times: %d wrong\n", seconds, failures - before);
  return failures == 0 ? 0 : 1;
}
