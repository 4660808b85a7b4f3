// SPDX-License-Identifier: Apache-2.0
#include "daemon/robot/allow_list.h"

#include <cstring>
#include <stdexcept>

#include <arpa/inet.h>

namespace geond::daemon {

bool AllowList::Parse(const std::string& text, Bytes& bytes, bool& is_v4) {
  bytes = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xff, 0xff, 0, 0, 0, 0};
  is_v4 = inet_pton(AF_INET, text.c_str(), bytes.data() + 12) == 1;
  return is_v4 || inet_pton(AF_INET6, text.c_str(), bytes.data()) == 1;
}

AllowList::AllowList(std::string_view text) {
  while (!text.empty()) {
    const std::size_t comma = std::min(text.find(','), text.size());
    std::string entry(text.substr(0, comma));
    text.remove_prefix(std::min(comma + 1, text.size()));
    entry.erase(0, std::min(entry.find_first_not_of(" \t"), entry.size()));
    entry.erase(entry.find_last_not_of(" \t") + 1);
    if (entry.empty()) continue;
    const auto fail = [&](const std::string& why) { throw std::invalid_argument("'" + entry + "' " + why); };

    const std::size_t slash = entry.find('/');
    Network network{};
    bool is_v4 = false;
    if (!Parse(entry.substr(0, slash), network.address, is_v4)) fail("is no IP address or network");
    const int most = is_v4 ? 32 : 128;
    int bits = most;
    if (slash != std::string::npos) {
      const std::string length = entry.substr(slash + 1);
      if (length.empty() || length.size() > 3 || length.find_first_not_of("0123456789") != std::string::npos ||
          (bits = std::stoi(length)) > most) {
        fail("has a length that is not 0 to " + std::to_string(most));
      }
    }
    network.bits = bits + (is_v4 ? 96 : 0);
    for (int bit = network.bits; bit < 128; ++bit) {
      if (network.address[bit / 8] >> (7 - bit % 8) & 1) fail("has bits set beyond its length: is it what was meant?");
    }
    networks_.push_back(network);
  }
}

bool AllowList::Contains(const std::string& address) const {
  Bytes bytes;
  bool is_v4 = false;
  if (!Parse(address, bytes, is_v4)) return false;
  for (const Network& network : networks_) {
    const int whole = network.bits / 8, rest = network.bits % 8;
    if (std::memcmp(bytes.data(), network.address.data(), static_cast<std::size_t>(whole)) != 0) continue;
    if (rest == 0 || (bytes[whole] ^ network.address[whole]) >> (8 - rest) == 0) return true;
  }
  return false;
}

}  // namespace geond::daemon
