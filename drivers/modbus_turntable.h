// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <map>
#include <mutex>
#include <string>
#include <thread>

#include "drivers/drive_profile.h"
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
  std::chrono::milliseconds motion_timeout{60'000};  // of one motion, beyond what speed and distance ask for
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

 private:
  using Values = std::map<std::string, std::int64_t>;
  using Clock = std::chrono::steady_clock;

  std::int64_t ReadRegister(const DriveRegister& what);
  void WriteStep(const DriveStep& step, const Values& values);
  void RunSequence(const std::string& name, const Values& values, std::stop_token stop);
  void WaitForStatus(const DriveStep& step, const std::string& sequence, std::stop_token stop);
  std::uint32_t CheckedStatus(const std::string& call);
  // Waits one poll period; throws Cancelled (after stopping the table) if asked to, DeviceError if it was halted.
  void Pause(std::chrono::milliseconds time, std::stop_token stop, const std::string& call);
  [[noreturn]] void FailAlarm(const std::string& call);
  void SetCommunicationTimeout();
  double steps_per_radian() const;
  // While the drive is enabled, asks its status often enough for its communication timeout.
  void KeepAlive(std::stop_token stop);
  template <typename Work>
  void Guarded(const std::string& call, const Work& work);

  ModbusTurntableOptions options_;
  mutable std::mutex state_mutex_;   // guards info_
  DeviceInfo info_;
  std::recursive_mutex link_mutex_;  // Halt may come from another thread than the rest
  ModbusLink link_;
  std::atomic<bool> halted_{false};
  std::condition_variable_any wake_;
  std::mutex wake_mutex_;
  std::jthread keep_alive_;
};

}  // namespace geond::drivers
