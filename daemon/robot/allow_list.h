// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace geond::daemon {

// Networks that may connect, as "192.168.1.0/24, 10.0.0.7, fd00::/8".
class AllowList {
 public:
  AllowList() = default;
  // Throws std::invalid_argument naming the entry: no address, a length out of range, bits set beyond the length.
  explicit AllowList(std::string_view text);
  bool empty() const { return networks_.empty(); }
  // Whether an address (as text, IPv4 also as ::ffff:a.b.c.d) is in one of them.
  bool Contains(const std::string& address) const;

 private:
  using Bytes = std::array<std::uint8_t, 16>;  // IPv4 is mapped into IPv6
  struct Network {
    Bytes address;
    int bits;
  };
  static bool Parse(const std::string& text, Bytes& bytes, bool& is_v4);
  std::vector<Network> networks_;
};

}  // namespace geond::daemon
