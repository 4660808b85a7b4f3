// SPDX-License-Identifier: Apache-2.0
#include "daemon/http_files.h"

#include <algorithm>
#include <array>
#include <charconv>

namespace geond::daemon {
namespace {

std::optional<std::uint64_t> Number(std::string_view text) {
  std::uint64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (text.empty() || error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

}  // namespace

std::string_view ContentType(const std::filesystem::path& path) {
  struct Type {
    std::string_view ending, type;
  };
  static constexpr std::array kTypes = {
      Type{".html", "text/html; charset=utf-8"}, Type{".js", "text/javascript; charset=utf-8"},
      Type{".css", "text/css; charset=utf-8"},   Type{".json", "application/json"},
      Type{".png", "image/png"},                 Type{".svg", "image/svg+xml"},
      Type{".ply", "application/octet-stream"}};
  const std::string ending = path.extension().string();
  const auto found = std::find_if(kTypes.begin(), kTypes.end(), [&](const Type& type) { return type.ending == ending; });
  return found == kTypes.end() ? "application/octet-stream" : found->type;
}

std::optional<ByteRange> ParseRange(std::string_view header, std::uint64_t size) {
  constexpr std::string_view kUnit = "bytes=";
  if (header.substr(0, kUnit.size()) != kUnit) return std::nullopt;
  header.remove_prefix(kUnit.size());
  const std::size_t dash = header.find('-');
  if (dash == std::string_view::npos || header.find(',') != std::string_view::npos) return std::nullopt;
  const std::optional<std::uint64_t> first = Number(header.substr(0, dash)), last = Number(header.substr(dash + 1));
  if (!first && !last) return std::nullopt;
  if (!first) {
    if (dash != 0) return std::nullopt;
    const std::uint64_t length = std::min(*last, size);
    return ByteRange{size - length, length};
  }
  if (!last && dash + 1 != header.size()) return std::nullopt;
  if (last && *last < *first) return std::nullopt;
  if (*first >= size) return ByteRange{0, 0};
  return ByteRange{*first, std::min(last.value_or(size - 1), size - 1) - *first + 1};
}

bool IsPlainPath(std::string_view path) {
  if (path.empty() || path.size() > 200) return false;
  char before = '/';
  for (const char letter : path) {
    const bool fine = (letter >= 'a' && letter <= 'z') || (letter >= 'A' && letter <= 'Z') || (letter >= '0' && letter <= '9') ||
                      letter == '.' || letter == '_' || letter == '-' || letter == '/';
    if (!fine || (before == '/' && (letter == '.' || letter == '/'))) return false;
    before = letter;
  }
  return true;
}

bool IsLoopbackName(std::string_view name) {
  for (const std::string_view scheme : {"http://", "https://"}) {
    if (name.substr(0, scheme.size()) == scheme) name.remove_prefix(scheme.size());
  }
  std::string_view port;
  if (!name.empty() && name.front() == '[') {
    const std::size_t end = name.find(']');
    if (end == std::string_view::npos) return false;
    port = name.substr(end + 1);
    name = name.substr(0, end + 1);
  } else if (const std::size_t colon = name.find(':'); colon != std::string_view::npos) {
    port = name.substr(colon);
    name = name.substr(0, colon);
  }
  if (!port.empty() && (port.front() != ':' || !Number(port.substr(1)))) return false;
  return name == "localhost" || name == "127.0.0.1" || name == "[::1]";
}

bool IsSameSite(std::string_view origin, std::string_view host) {
  if (IsLoopbackName(origin) && IsLoopbackName(host)) return true;
  for (const std::string_view scheme : {"http://", "https://"}) {
    if (origin.substr(0, scheme.size()) == scheme) return !host.empty() && origin.substr(scheme.size()) == host;
  }
  return false;
}

}  // namespace geond::daemon
