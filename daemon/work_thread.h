// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>

namespace geond::daemon {

// Hands a task to another thread. Safe from any thread.
using Post = std::function<void(std::function<void()>)>;

// A thread that does what is posted to it, one thing after the other. Tasks must not throw.
class WorkThread {
 public:
  WorkThread();
  // Finishes what was posted, then ends.
  ~WorkThread();
  WorkThread(const WorkThread&) = delete;
  WorkThread& operator=(const WorkThread&) = delete;

  // Safe from any thread.
  void Post(std::function<void()> task);
  // Counts what was done: ended tasks and calls of Tick. A thread with work whose count stands still hangs.
  std::uint64_t progress() const { return progress_.load(std::memory_order_relaxed); }
  bool idle() const { return waiting() == 0; }
  // Tasks posted and not ended.
  int waiting() const { return waiting_.load(std::memory_order_relaxed); }
  // To be called inside long tasks.
  void Tick() { progress_.fetch_add(1, std::memory_order_relaxed); }

 private:
  void Run();

  std::mutex mutex_;
  std::condition_variable woken_;
  std::deque<std::function<void()>> tasks_;
  bool ends_ = false;
  std::atomic<std::uint64_t> progress_{0};
  std::atomic<int> waiting_{0};
  std::thread thread_;
};

}  // namespace geond::daemon
