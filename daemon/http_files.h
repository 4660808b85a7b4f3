// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

// What of HTTP is plain text and numbers, without a socket.
namespace geond::daemon {

// "text/html; charset=utf-8" and so on, by the ending of a file.
std::string_view ContentType(const std::filesystem::path& path);

// A byte range of a file.
struct ByteRange {
  std::uint64_t first = 0, length = 0;
};
// What "bytes=first-last", "bytes=first-" or "bytes=-count" asks of a file of `size` bytes. Nothing if it asks for several
// ranges or is no range at all (the whole file is the answer then); a length of 0 if nothing of it is in the file.
std::optional<ByteRange> ParseRange(std::string_view header, std::uint64_t size);

// The part of a path below a folder that may be served: no "..", no hidden names, only letters, digits and . _ - /.
bool IsPlainPath(std::string_view path);

// Whether a Host or Origin names this machine by a loopback name ("localhost:7180", "http://127.0.0.1:7180", "[::1]").
bool IsLoopbackName(std::string_view host_or_origin);

// Whether a page of that Origin may ask this Host: they are the same place, or both this machine.
bool IsSameSite(std::string_view origin, std::string_view host);

}  // namespace geond::daemon
