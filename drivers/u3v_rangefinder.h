// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "drivers/fault_signal.h"
#include "drivers/genicam.h"
#include "drivers/rangefinder.h"
#include "drivers/u3v_control.h"
#include "drivers/u3v_depth.h"
#include "drivers/u3v_stream.h"
#include "drivers/usb_port.h"

namespace geond::drivers {

struct U3vRangefinderOptions {
  enum class Trigger { kSoftware, kWire, kNone };  // none: the camera sends images by itself
  Trigger trigger = Trigger::kSoftware;
  std::string trigger_line = "Line0";        // TriggerSource for a wire
  std::string pixel_format = "Coord3D_C16";  // as the camera names it; must carry depth
  std::optional<double> exposure_us;         // absent: as the camera has it
  std::optional<SensorModel> sensor;         // absent: by the camera's own account
  double depth_noise = 0.0002;               // m; no camera says it
  bool may_be_absent = false;  // when made: rather be absent or faulted until Reset than throw
  std::chrono::milliseconds watch_period{20};  // between looks whether it is still plugged in
  u3v::ControlOptions control;
};

// A U3V compatible range camera. Reset brings it up anew, if need be after resetting the device
// and opening it again.
class U3vRangefinder final : public Rangefinder {
 public:
  // Opens the camera and reads what it is. Throws DeviceError, TimeoutError (unless it may be absent).
  U3vRangefinder(UsbOpener open, U3vRangefinderOptions options);
  ~U3vRangefinder() override;

  DeviceInfo info() const override;
  SensorModel sensor_model() const override { return sensor_; }
  void Arm() override;
  void Trigger() override;
  Exposure Read(std::chrono::milliseconds timeout, std::stop_token stop) override;
  void Disarm() noexcept override;
  void Reset() override;
  void OnFault(FaultListener listener) override { signal_.Set(std::move(listener)); }

 private:
  void BringUp();
  void Open();
  void Watch(std::stop_token stop);
  void ReadDescription();
  void ReadSensor();
  void ReadScale();
  double ReadFloatOr(const char* feature, double otherwise) const;
  double Metres() const;  // in the camera's unit of distance
  void StopStream();
  void StartStream();
  bool Has(const char* feature) const;
  void SetIfPresent(const char* feature, const char* entry);

  const UsbOpener open_;
  const U3vRangefinderOptions options_;
  std::mutex call_mutex_;  // held by each call, so that Watch looks only between calls
  mutable std::mutex info_mutex_;
  DeviceInfo info_;
  FaultSignal signal_;
  std::unique_ptr<UsbPort> port_;
  std::unique_ptr<u3v::ControlChannel> control_;
  std::unique_ptr<genicam::Description> description_;
  std::unique_ptr<u3v::StreamReader> stream_;
  genicam::Memory memory_;
  SensorModel sensor_;
  u3v::DepthScale scale_;
  std::jthread watch_;  // last, so that it ends first
};

}  // namespace geond::drivers
