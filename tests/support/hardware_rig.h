// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "core/range/range_image.h"
#include "daemon/command/service_client.h"
#include "sim/usb/fake_wires.h"

namespace geond {

// The address sanitizer cannot run below umockdev's preloaded library, so neither can a geond built with it.
#if defined(__SANITIZE_ADDRESS__)
inline constexpr bool kRigCannotRun = true;
#else
inline constexpr bool kRigCannotRun = false;
#endif

// A geond of its own process on a bench of fake devices, or on the simulated station that the bench shows, in a folder
// that is gone with it. One a program at a time.
class HardwareRig {
 public:
  using Clock = std::chrono::steady_clock;

  struct Options {
    bool hardware = true;                    // else the twins of the same scene
    int pixels = 96;                         // columns and rows of an image
    double table_speed = 180;                // degrees a second
    int drive_baud = 230400;                 // of the fake drive; geond takes the profile's
    bool patient = false;                    // limits that a sound device keeps are seconds, as if this machine were slow
    std::vector<std::string> settings = {};  // further "table.key=value" for geond
  };
  explicit HardwareRig(const Options& options);
  ~HardwareRig();
  HardwareRig(const HardwareRig&) = delete;
  HardwareRig& operator=(const HardwareRig&) = delete;

  sim::FakeBench& bench() { return *bench_; }
  const std::filesystem::path& folder() const { return folder_; }

  void Start();  // geond, and waits until it answers
  void Kill();   // with signal 9
  void Signal(int number);
  int Stop();                                          // with SIGTERM; its exit status
  int Run(const std::vector<std::string>& arguments);  // geond, to its end
  int OpenDescriptors() const;                         // of geond
  std::string Log() const;                             // what it wrote
  daemon::Json Call(const std::string& method, const daemon::Json& params = daemon::Json::object());
  // The parameters of the next event of this name, those before it thrown away.
  daemon::Json WaitForEvent(const std::string& event);
  // The same for the end of the scan under way: its "scan" event that is not "running".
  daemon::Json WaitForScanEnd();
  std::filesystem::path ScanFolder(int scan) const;

 private:
  std::vector<std::string> Arguments() const;
  void WriteFiles(const Options& options);

  const bool hardware_;
  std::vector<std::string> settings_;
  std::filesystem::path folder_;
  std::unique_ptr<sim::FakeBench> bench_;
  std::unique_ptr<sim::FakeWires> wires_;
  std::unique_ptr<daemon::ServiceClient> client_;
  pid_t geond_ = -1;
};

}  // namespace geond
