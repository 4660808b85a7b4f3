// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

namespace geond::daemon {

// Puts `bytes` into the file so that after a crash it holds either them or what it held before: written beside it, synced,
// renamed, the folder synced. Throws FileError (disk full, read-only, ...).
void WriteDurably(const std::filesystem::path& path, std::string_view bytes);

// Makes what a finished file or folder holds survive a power cut. Throws FileError.
void SyncFile(const std::filesystem::path& path);
void SyncFolder(const std::filesystem::path& folder);

// The whole file. Throws FileError; also if it has more than `max_bytes`.
std::string ReadWhole(const std::filesystem::path& path, std::size_t max_bytes = std::size_t{1} << 30);

// When a file was last written, s since 1970. Throws FileError.
std::int64_t ModifiedAt(const std::filesystem::path& path);

}  // namespace geond::daemon
