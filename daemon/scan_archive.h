// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <stop_token>

namespace geond::daemon {

// Writes the files of a scan's folder into one zip archive, under the folder's name, in an order that depends on their
// names alone. The archive appears whole or not at all. Throws FileError, Cancelled.
void WriteScanArchive(const std::filesystem::path& folder, const std::filesystem::path& archive,
                      std::stop_token stop = {});

struct ArchiveLimits {
  std::uint64_t max_bytes = std::uint64_t{4} << 30;  // unpacked
  int max_files = 4000;
};

// Unpacks an archive that WriteScanArchive made into a folder of its own, synced. What is in it is not trusted: names
// that lead elsewhere, more than the limits, a wrong sum, files that do not make a scan throw FileError and leave
// nothing behind.
void ReadScanArchive(const std::filesystem::path& archive, const std::filesystem::path& folder,
                     const ArchiveLimits& limits = {}, std::stop_token stop = {});

}  // namespace geond::daemon
