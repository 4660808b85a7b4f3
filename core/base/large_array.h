// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/mman.h>

#include <cstddef>
#include <cstdlib>
#include <memory>
#include <new>
#include <type_traits>

namespace geond {

struct FreeMemory {
  void operator()(void* memory) const { std::free(memory); }
};
template <typename T>
using LargeArray = std::unique_ptr<T[], FreeMemory>;

// n numbers, not initialised, in large pages where the machine has them to give: a big array is then touched and walked
// through with far fewer page faults. Throws std::bad_alloc.
template <typename T>
LargeArray<T> MakeLargeArray(std::size_t n) {
  static_assert(std::is_trivial_v<T>);
  constexpr std::size_t kPage = std::size_t{1} << 21;
  const std::size_t alignment = n * sizeof(T) >= 2 * kPage ? kPage : 64;
  const std::size_t bytes = (n * sizeof(T) / alignment + 1) * alignment;
  void* const memory = std::aligned_alloc(alignment, bytes);
  if (!memory) throw std::bad_alloc();
  if (alignment == kPage) madvise(memory, bytes, MADV_HUGEPAGE);  // a wish: without it all is as before
  return LargeArray<T>(static_cast<T*>(memory));
}

}  // namespace geond
