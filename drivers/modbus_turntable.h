// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "drivers/drive_profile.h"
#include "drivers/fault_signal.h"
#include "drivers/modbus_link.h"
#include "drivers/turntable.h"

namespace geond::drivers {

struct ModbusTurntableOptions {
  ModbusAddress address;
  DriveProfile profile;
  double gear_ratio = 1.0;        // turns of the motor for one turn of the table; negative: they turn opposite ways
  double speed = 0.6;             // of the table, rad/s
  double acceleration = 1.0;      // of the table, rad/s^2
  double tolerance = 0.0005;      // rad: nearer to the target is in position
  double min_angle = -1e9, max_angle = 1e9;  // rad, unwrapped: soft limits
  std::chrono::milliseconds settle_time{200};
  std::chrono::milliseconds poll_period{10};
  std::chrono::milliseconds motion_timeout{1000};    // of one motion, beyond 1.5 times what it should take
  std::chrono::milliseconds stall_time{1000};        // a motor that is to turn and does not for so long is stuck
  std::chrono::milliseconds watch_period{40};        // between looks at a drive that is enabled and not asked otherwise
};

// A turntable on a Modbus drive, spoken to by its profile. The communication timeout is written and read back when it is
// enabled; motions are repeated within the drive's lifetime, so that either end's death stops the table.
class ModbusTurntable final : public Turntable {
 public:
  explicit ModbusTurntable(ModbusTurntableOptions options);
  ~ModbusTurntable() override;

  DeviceInfo info() const override;
  void Enable() override;
  void Home(std::stop_token stop) override;
  void MoveTo(double angle, std::stop_token stop) override;
  double angle() override;
  bool moving() override;
  void Halt() noexcept override;
  void Disable() noexcept override;
  void Reset() override;
  void OnFault(FaultListener listener) override { signal_.Set(std::move(listener)); }

 private:
  using Values = std::map<std::string, std::int64_t>;
  using Clock = std::chrono::steady_clock;

  std::int64_t ReadRegister(const DriveRegister& what);
  std::vector<std::uint16_t> WordsOf(const DriveStep& step, const Values& values) const;
  void WriteStep(const DriveStep& step, const Values& values);
  void RunSequence(const std::string& name, const Values& values, std::stop_token stop);
  void WaitForStatus(const DriveStep& step, const std::string& sequence, std::stop_token stop);
  std::uint32_t CheckedStatus(const std::string& call);
  // Waits one poll period; throws Cancelled (after stopping the table) if asked to, DeviceError if it was halted.
  void Pause(std::chrono::milliseconds time, std::stop_token stop, const std::string& call);
  [[noreturn]] void FailAlarm(const std::string& call);
  void SetCommunicationTimeout();
  double steps_per_radian() const;
  // While the drive is enabled, asks its status often enough for its communication timeout and to tell of its loss.
  void KeepAlive(std::stop_token stop);
  // Throws DeviceError if a motor that is to turn has not for the stall time; call it with each status that is read.
  struct Stall {
    std::optional<std::int64_t> position;
    Clock::time_point since;
  };
  void CheckStall(Stall& stall, const std::string& call);
  // One request without a look at what went before, and no longer than one reply takes: for stopping.
  void WriteOnce(const std::string& sequence) noexcept;
  template <typename Work>
  void Guarded(const std::string& call, const Work& work);

  ModbusTurntableOptions options_;
  mutable std::mutex state_mutex_;   // guards info_
  DeviceInfo info_;
  std::recursive_timed_mutex link_mutex_;  // Halt may come from another thread than the rest
  ModbusLink link_;
  std::atomic<bool> halted_{false};
  std::condition_variable_any wake_;
  std::mutex wake_mutex_;
  FaultSignal signal_;
  std::jthread keep_alive_;
};

}  // namespace geond::drivers
