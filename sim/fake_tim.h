// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>

#include "drivers/cola.h"
#include "drivers/usb_port.h"
#include "sim/scene.h"

namespace geond::sim {

// What goes wrong with the fake scanner's wire; the numbers count down to zero as it happens.
struct FakeTimFaults {
  bool silent = false;   // answers nothing, sends nothing
  bool refuses = false;  // every command
  bool unplugged = false;
  std::uint16_t status = 0;  // of its lines: 1 device error, 5 pollution error
  int broken_lines = 0;      // with a wrong checksum, or cut short
  int lost_lines = 0;        // counted, not sent
};

// A SICK TiM line scanner seen from its USB endpoints: commands, and 15 lines a second while they are wanted. Its time
// is that which its reader waits for, so that nothing depends on how fast this machine is. Any thread.
class FakeTim {
 public:
  using TakeLine = std::function<std::vector<float>()>;  // ranges, m, NaN for nothing
  static constexpr int kReadings = 271;
  static constexpr double kFirstAngle = -0.78539816339744828, kStep = 0.017453292519943295;  // rad: -45 and 1 degrees

  FakeTim(drivers::cola::Protocol protocol, TakeLine take, std::string serial = "TIM0001")
      : protocol_(protocol), take_(std::move(take)), serial_(std::move(serial)) {}

  // One transfer to it.
  void Receive(drivers::cola::ByteView data);
  // One transfer from it: what it says within `wait`, of which as much passes as that takes; none: nothing to say.
  drivers::cola::Bytes Send(std::chrono::microseconds wait);
  std::chrono::microseconds now() const;
  void SetFaults(const FakeTimFaults& faults);
  FakeTimFaults faults() const;
  bool scanning() const;
  const std::string& serial() const { return serial_; }

 private:
  void Obey(const drivers::cola::Telegram& telegram);
  void Say(const std::string& text, drivers::cola::ByteView binary = {});
  drivers::cola::Bytes Line();

  const drivers::cola::Protocol protocol_;
  const TakeLine take_;
  const std::string serial_;
  mutable std::mutex mutex_;
  drivers::cola::Bytes received_, answers_;
  bool scanning_ = false;
  std::chrono::microseconds now_{0}, next_line_{0};
  std::uint32_t lines_ = 0;
  FakeTimFaults faults_;
};

// A port straight into the fake scanner, without USB between. Throws DeviceError if it is unplugged.
std::unique_ptr<drivers::UsbPort> OpenFakeTim(const std::shared_ptr<FakeTim>& scanner);

// What a scanner at X_TS (x right, y down, z to the middle of its field) sees of a scene in its x-z plane: ranges along
// FakeTim's directions, to the millimetre.
std::vector<float> TakeScanLine(const SceneGeometry& scene, const Pose& X_TS);

}  // namespace geond::sim
