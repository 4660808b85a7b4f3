// SPDX-License-Identifier: Apache-2.0
#include "daemon/work_thread.h"

#include <utility>

namespace geond::daemon {

WorkThread::WorkThread() : thread_([this] { Run(); }) {}

WorkThread::~WorkThread() {
  {
    const std::lock_guard lock(mutex_);
    ends_ = true;
  }
  woken_.notify_one();
  thread_.join();
}

void WorkThread::Post(std::function<void()> task) {
  waiting_.fetch_add(1, std::memory_order_relaxed);
  {
    const std::lock_guard lock(mutex_);
    tasks_.push_back(std::move(task));
  }
  woken_.notify_one();
}

void WorkThread::Run() {
  std::unique_lock lock(mutex_);
  while (true) {
    woken_.wait(lock, [this] { return ends_ || !tasks_.empty(); });
    if (tasks_.empty()) return;
    std::function<void()> task = std::move(tasks_.front());
    tasks_.pop_front();
    lock.unlock();
    task();
    task = nullptr;  // what it held is let go on this thread
    Tick();
    waiting_.fetch_sub(1, std::memory_order_relaxed);
    lock.lock();
  }
}

}  // namespace geond::daemon
