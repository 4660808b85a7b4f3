// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <chrono>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "drivers/lines.h"

struct gpiod_chip;
struct gpiod_line;

namespace geond::drivers {

// One wire: a line of a GPIO chip. "On" (of an input: pressed, open) is high, or low if active_low.
struct GpioWire {
  enum class Bias { kAsIs, kNone, kPullUp, kPullDown };
  std::string chip;     // "/dev/gpiochip0", or the chip's name or label
  unsigned offset = 0;  // of the line in the chip, ...
  std::string line = {};  // ... or its name there, if not empty
  bool active_low = false;
  Bias bias = Bias::kAsIs;
};

// Choose polarity and pull resistors so that a wire that is cut or let go is safe: outputs off, inputs pressed or open.
struct GpioLinesOptions {
  GpioWire laser;
  GpioWire emergency_stop;
  std::optional<GpioWire> motor, lamp, trigger, door;  // absent: not wired
  std::chrono::microseconds trigger_pulse{500};
  std::chrono::milliseconds longest_call{100};  // a chip that takes longer for a call has failed
  bool may_be_absent = false;  // when made: rather be absent until inputs() finds the lines than throw
  std::chrono::milliseconds debounce{20};  // an input counts as released only after it was quiet for so long
};

// The station's wires on GPIO lines. Outputs are off when it is made, when it is destroyed and when the process dies
// (as far as the chip lets its lines go). An input that is pressed for an instant is seen by the next ReadEvents or
// inputs(). After a failed call nothing can be switched on until inputs() or ReadEvents has requested all lines anew,
// outputs off; so a chip that vanished may come back. All methods from any thread.
class GpioLines final : public Lines {
 public:
  // Throws std::invalid_argument if two wires share a line, DeviceError naming wire and chip if one cannot be had
  // (unless it may be absent).
  explicit GpioLines(GpioLinesOptions options);
  ~GpioLines() override;
  GpioLines(const GpioLines&) = delete;
  GpioLines& operator=(const GpioLines&) = delete;

  DeviceInfo info() const override;
  void SetLaser(bool on) override;
  void SetMotor(bool on) override;
  void SetLamp(bool on) override;
  bool laser() const override { return laser_.on; }
  bool motor() const override { return motor_.on; }
  void PulseTrigger() override;
  Inputs inputs() override;
  int event_fd() const override { return event_fd_; }
  Inputs ReadEvents() override;
  void AllOff() noexcept override;

 private:
  struct Wire {
    const char* name;
    std::optional<GpioWire> where = {};
    gpiod_line* line = nullptr;  // requested; owned by its chip
    std::atomic<bool> on = false;  // an output: as it was last set; an input: as it is taken to be
    std::chrono::steady_clock::time_point active{};  // an input: when it was last seen on
  };
  struct CloseChip { void operator()(gpiod_chip* chip) const; };

  void Open();
  void Release() noexcept;
  gpiod_chip* Chip(const std::string& name);
  void Request(Wire& wire, bool output);
  void Set(Wire& wire, const char* call, bool on);
  void Drive(Wire& wire, const char* call, bool on);
  void CheckPace(const char* call, const Wire& wire, std::chrono::steady_clock::time_point begin);
  void ReadInput(Wire& wire);
  void ArmTimer();
  Inputs ReadAll(const char* call);
  [[noreturn]] void Fail(const char* call, const Wire& wire, int error);

  const GpioLinesOptions options_;
  Wire laser_{"laser"}, motor_{"motor"}, lamp_{"lamp"}, trigger_{"trigger"};
  Wire emergency_stop_{"emergency stop"}, door_{"door"};
  int event_fd_ = -1, timer_fd_ = -1;
  mutable std::mutex mutex_;          // of lines, chips and fault_; never held while waiting
  std::mutex trigger_mutex_;          // one pulse at a time
  std::vector<std::pair<std::string, std::unique_ptr<gpiod_chip, CloseChip>>> chips_;
  std::string fault_;
  bool slow_ = false;  // the chip took too long: from then on it is rather let go than asked
};

// "laser, line 4 of /dev/gpiochip0", or with the name of the line.
std::string WireWords(const char* name, const GpioWire& wire);

}  // namespace geond::drivers
