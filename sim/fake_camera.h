// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/range/range_image.h"
#include "core/range/sensor_model.h"
#include "drivers/usb_port.h"

namespace geond::sim {

// What goes wrong with the fake camera's wire next; each number counts down to zero as it happens.
struct FakeCameraFaults {
  int lost_acknowledges = 0;     // never sent
  int stale_acknowledges = 0;    // the one before is sent again first
  int broken_acknowledges = 0;   // without their magic number
  int short_acknowledges = 0;    // cut by two bytes
  int pending_acknowledges = 0;  // "still at work" first
  int busy_answers = 0;
  int control_stalls = 0;
  int bad_leaders = 0;
  int short_payloads = 0;
  int overrun_trailers = 0;  // trailer says that data was lost
  int wrong_blocks = 0;      // trailer of another block
  int lost_frames = 0;       // numbered, not sent
  int half_images = 0;       // half the rows, honestly announced in the trailer
  int stream_stalls = 0;
  bool silent = false;  // answers nothing
  bool every_second_lost = false;             // of the frames
  std::chrono::milliseconds frame_delay{0};   // from trigger to frame, beyond the exposure
};

// A U3V compatible range camera seen from its USB endpoints: registers, description, stream. It takes an image for each
// trigger by calling `take`; with its trigger off it sends one image again and again, as fast as it is read. Any thread.
class FakeCamera {
 public:
  static constexpr std::uint8_t kControlOut = 0x01, kControlIn = 0x81, kStreamIn = 0x82;
  static constexpr int kNothingYet = -11, kStall = -32, kOverflow = -75;  // as errno: EAGAIN, EPIPE, EOVERFLOW

  // `take` is called for each trigger that is heard, on whatever thread; no image: no frame is sent.
  FakeCamera(const SensorModel& sensor, std::function<std::optional<RangeImage>()> take, std::string serial = "FC0001");

  // One transfer: bytes moved, or one of the negative numbers above.
  int Transfer(std::uint8_t endpoint, std::span<std::uint8_t> data);
  void SetHalt(std::uint8_t endpoint, bool halted);
  void ResetDevice();
  void WireTrigger();
  void SetFaults(const FakeCameraFaults& faults);
  FakeCameraFaults faults() const;
  void SetPlugged(bool plugged);
  bool plugged() const;
  // Waits until something may have changed since the last call or the time is over.
  void WaitForChange(std::chrono::milliseconds timeout);
  // Whether something else is sent behind each image, in the way that the standard has for it.
  void SetChunks(bool chunks);
  // How long from a trigger to its frame; 0 at first.
  void SetExposureTime(std::chrono::milliseconds time);
  bool acquiring() const;
  std::uint64_t frames() const;
  const std::string& serial() const { return serial_; }

 private:
  using Bytes = std::vector<std::uint8_t>;
  using Clock = std::chrono::steady_clock;
  struct Message {
    Bytes bytes;
    Clock::time_point ready;
    bool ends_early = false;  // an empty packet behind it says so, where its length does not
    bool told = false;        // that it is ready
  };
  std::uint64_t Get(std::uint64_t address, std::size_t size) const;
  void Put(std::uint64_t address, std::uint64_t value, std::size_t size);
  void PutText(std::uint64_t address, const std::string& text);
  int Command(std::span<const std::uint8_t> packet);
  void Acknowledge(std::uint16_t status, std::uint16_t command, std::uint16_t id, std::span<const std::uint8_t> data);
  void Written(std::uint64_t address, std::size_t size);
  void UpdatePayloadSize();
  void Trigger(bool wire);
  void SendFrame();
  bool RunsFree() const;
  Bytes EncodePayload(const RangeImage& image, std::uint32_t rows) const;
  int ReadStream(std::span<std::uint8_t> data);
  void StopAcquisition();

  const SensorModel sensor_;
  const std::function<std::optional<RangeImage>()> take_;
  const std::string serial_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::uint64_t changes_ = 0, seen_changes_ = 0;
  Bytes memory_;
  std::deque<Bytes> acknowledges_;
  Bytes last_acknowledge_;
  std::deque<Message> stream_;  // each ends with a short packet, or as its length says
  std::size_t stream_at_ = 0;  // in the front one
  bool control_halted_ = false, stream_halted_ = false;
  bool acquiring_ = false, plugged_ = true;
  std::uint64_t block_ = 0, frames_ = 0;
  Bytes free_payload_;  // what it sends with its trigger off; empty: not taken yet
  bool chunks_ = false;
  std::chrono::milliseconds exposure_time_{0};
  FakeCameraFaults faults_;
};

// The GenICam description of the fake camera, whose feature registers begin at `base`.
std::string FakeCameraDescription(std::uint64_t base, const SensorModel& sensor);

// A port straight into the fake camera, without USB between.
std::unique_ptr<drivers::UsbPort> OpenFakeCamera(const std::shared_ptr<FakeCamera>& camera);

}  // namespace geond::sim
