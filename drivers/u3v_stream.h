// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <deque>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "drivers/u3v_protocol.h"
#include "drivers/usb_port.h"

namespace geond::drivers::u3v {

// How one frame is cut into transfers; all sizes in bytes and multiples of the device's alignment.
struct StreamLayout {
  std::size_t leader = 0, trailer = 0;
  std::size_t payload = 0;                   // of a whole frame, not rounded
  std::size_t transfer = 0, transfers = 0;   // equal parts of the payload ...
  std::size_t last_transfer = 0;             // ... and the rest, rounded up; 0: none
};
// Throws std::invalid_argument if alignment is no power of two or the payload is empty.
StreamLayout PlanStream(std::uint64_t payload, std::size_t leader, std::size_t trailer, std::size_t alignment);

struct Frame {
  Leader leader;
  Trailer trailer;
  Bytes payload;
};

// Takes frames off the stream, some 8 MiB of reads under way at most.
class StreamReader {
 public:
  StreamReader(UsbPort& port, StreamLayout layout) : port_(port), layout_(layout) {}
  ~StreamReader() { port_.CancelReads(); }
  StreamReader(const StreamReader&) = delete;
  StreamReader& operator=(const StreamReader&) = delete;

  // Posts reads for a new frame, ending those that are posted. Throws DeviceError.
  void Start();
  // The next whole frame that breaks no rule. Throws DeviceError naming the broken rule, TimeoutError,
  // Cancelled. After an error Start is needed.
  Frame Next(std::chrono::milliseconds timeout, std::stop_token stop);
  // Takes a frame that is no longer needed back, for its memory.
  void GiveBack(Frame frame);
  // Throws away frames that are there already.
  void DiscardWaiting();
  // Why the last Next failed, if it was the endpoint itself.
  UsbPort::Status last_status() const { return last_status_; }
  std::uint64_t frames_missed() const { return missed_; }  // gaps in the numbers of the frames

 private:
  // What one frame is read into. Its payload's reads lie one behind the other, so that it need not be moved.
  struct Buffers {
    Bytes leader, payload, trailer;
  };

  std::size_t reads() const { return layout_.transfers + (layout_.last_transfer != 0 ? 3 : 2); }
  std::span<std::uint8_t> PlaceOfRead(Buffers& buffers, std::size_t index) const;
  Buffers TakeSpare();
  void Post();
  void Forget();
  std::optional<Frame> Take(std::size_t size);
  [[noreturn]] void Fail(const std::string& cause);

  UsbPort& port_;
  const StreamLayout layout_;
  std::deque<Buffers> frames_;      // of the reads posted and of the frame being taken, oldest first
  std::vector<Buffers> spare_;
  std::size_t posted_ = 0, posted_bytes_ = 0;
  std::size_t next_read_ = 0;       // of the last of frames_: 0 leader, then the payload's, then the trailer
  std::size_t next_taken_ = 0;      // the same of frames_[taking_]
  std::size_t taking_ = 0, kept_ = 0;  // frames_[kept_].payload has what came of the payload
  bool shifted_ = false;            // a short payload moved what follows into other reads
  std::optional<Leader> leader_;
  std::size_t received_ = 0;        // bytes of the payload
  std::optional<std::uint64_t> last_block_;
  std::uint64_t missed_ = 0;
  UsbPort::Status last_status_ = UsbPort::Status::kOk;
};

}  // namespace geond::drivers::u3v
