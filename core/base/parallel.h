// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace geond {

// The number of threads to use: `wanted`, or one a processor if wanted <= 0.
inline int ThreadCount(int wanted) {
  return wanted > 0 ? wanted : std::max(1u, std::thread::hardware_concurrency());
}

// Calls body(i) for 0 <= i < n, `chunk` consecutive ones at a time, on up to `threads` threads (<= 0: all processors).
// Which thread gets which chunk is not fixed: body(i) must write to places of its own, so that the result is the same for
// any number of threads. The first exception thrown is thrown again here.
template <typename Body>
void ParallelFor(std::ptrdiff_t n, int threads, std::ptrdiff_t chunk, const Body& body) {
  chunk = std::max<std::ptrdiff_t>(1, chunk);
  threads = static_cast<int>(std::min<std::ptrdiff_t>(ThreadCount(threads), (n + chunk - 1) / chunk));
  if (threads <= 1) {
    for (std::ptrdiff_t i = 0; i < n; ++i) body(i);
    return;
  }
  std::atomic<std::ptrdiff_t> next{0};
  std::exception_ptr failure;
  std::mutex failure_mutex;
  const auto work = [&] {
    try {
      for (std::ptrdiff_t begin; (begin = next.fetch_add(chunk)) < n;) {
        for (std::ptrdiff_t i = begin; i < std::min(n, begin + chunk); ++i) body(i);
      }
    } catch (...) {
      const std::lock_guard lock(failure_mutex);
      if (!failure) failure = std::current_exception();
      next.store(n);
    }
  };
  {
    std::vector<std::jthread> workers;
    for (int t = 1; t < threads; ++t) workers.emplace_back(work);
    work();
  }
  if (failure) std::rethrow_exception(failure);
}

}  // namespace geond
