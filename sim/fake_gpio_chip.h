// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <mutex>
#include <string>
#include <vector>

namespace geond::sim {

// A GPIO chip as the kernel shows it to programs (character device, first version of the interface): what its ioctls
// answer, and lines that are file descriptors with events to wait for. Levels are of the wire: true is high. Lines that
// a program lets go, or dies with, become inputs and read low, as pulled by the hardware. Any thread.
class FakeGpioChip {
 public:
  explicit FakeGpioChip(unsigned lines, std::string label = "fake gpio");
  ~FakeGpioChip();
  FakeGpioChip(const FakeGpioChip&) = delete;
  FakeGpioChip& operator=(const FakeGpioChip&) = delete;

  // Names of the lines, from the first on.
  void SetNames(const std::vector<std::string>& names);

  // One ioctl on the chip's or one of its lines' descriptors: its result, or -errno.
  int Ioctl(int fd, unsigned long request, void* argument);
  // The same by the descriptor's inode if it is a socket, as another process tells it, else 0.
  int IoctlOn(std::uint64_t inode, unsigned long request, void* argument);

  void SetInput(unsigned line, bool high);
  bool level(unsigned line);
  bool is_output(unsigned line);
  std::string consumer(unsigned line);  // empty: nobody holds it
  int rises(unsigned line);             // how often it went from low to high

  // Faults. Unplugged: every call fails with ENODEV, descriptors hang up. Stuck: outputs stay as they are. Failing: so
  // many of the next calls end with EIO. Slow: every call takes that long. Intermittent: every second call ends with EIO.
  void Unplug();
  void PlugIn();
  void SetStuck(bool stuck);
  void FailCalls(int count);
  void SetSlow(std::chrono::milliseconds time);
  void SetIntermittent(bool intermittent);

 private:
  struct Line {
    bool high = false, output = false;
    std::string name, consumer;
    int rises = 0;
  };
  struct Handle {
    int fd = -1;  // our end
    std::vector<unsigned> lines;
    bool output = false, active_low = false;
    unsigned edges = 0;
  };
  int HandleChip(unsigned long request, void* argument);
  int NewHandle(Handle handle, const char* consumer);
  void DropReleased();
  void Drop(const Handle& handle);
  void SetLevel(unsigned line, bool high);

  std::mutex mutex_;
  const std::string label_;
  std::vector<Line> lines_;
  std::map<std::uint64_t, Handle> handles_;  // by inode of the program's end
  bool unplugged_ = false, stuck_ = false, intermittent_ = false;
  std::chrono::milliseconds slow_{0};
  int failing_ = 0;
  std::uint64_t calls_ = 0;
};

}  // namespace geond::sim
