// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

// A disk that loses power at a chosen moment, for the program it is linked into. It stands before the calls that make,
// write, sync, rename and remove files, and remembers of every file below one folder what is safe: the bytes at its
// last fsync, and the changes of names whose folder was synced since. At the chosen call it puts the folder into a
// state that a power cut may leave, and ends the program with SIGKILL.
namespace losing_disk {

enum class Loss {
  kNothing,  // the program is killed, the system lives on
  kAll,      // nothing survives that was not synced
  kTorn,     // of every unsynced file some blocks of 512 bytes, in any order, of any length between; of the changes of
             // names in a folder those up to some moment
};

// From now on. `crash_at` counts the calls, from 1; 0: never.
void Arm(const std::string& folder, int crash_at, Loss loss, std::uint64_t seed);
// Calls so far.
int calls();

}  // namespace losing_disk
