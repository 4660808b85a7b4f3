// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace geond::drivers {

// The unsigned integer at `offset` of `bytes`, little-endian. The caller makes sure that it lies inside.
template <std::unsigned_integral Integer>
Integer ReadLittleEndian(std::span<const std::uint8_t> bytes, std::size_t offset) {
  Integer value = 0;
  for (std::size_t i = 0; i < sizeof(Integer); ++i) {
    value = static_cast<Integer>(value | static_cast<Integer>(Integer{bytes[offset + i]} << (8 * i)));
  }
  return value;
}

template <std::unsigned_integral Integer>
void AppendLittleEndian(Integer value, std::vector<std::uint8_t>& bytes) {
  for (std::size_t i = 0; i < sizeof(Integer); ++i) bytes.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
}

}  // namespace geond::drivers
