// SPDX-License-Identifier: Apache-2.0
#include "drivers/u3v_stream.h"

#include <algorithm>
#include <bit>
#include <stdexcept>
#include <utility>

#include "core/base/error.h"
#include "core/base/progress.h"

namespace geond::drivers::u3v {
namespace {

using Status = UsbPort::Status;
using Clock = std::chrono::steady_clock;

constexpr std::size_t kLargestTransfer = 1 << 20;
constexpr std::size_t kMostUnderWay = 8 << 20;
constexpr std::size_t kPacket = 1024;
constexpr std::chrono::milliseconds kGlance(20);  // between looks at a stop request

std::size_t RoundUp(std::size_t size, std::size_t alignment) { return (size + alignment - 1) / alignment * alignment; }

}  // namespace

StreamLayout PlanStream(std::uint64_t payload, std::size_t leader, std::size_t trailer, std::size_t alignment) {
  if (!std::has_single_bit(alignment) || alignment > kLargestTransfer || payload == 0) {
    throw std::invalid_argument("PlanStream: alignment " + std::to_string(alignment) + ", payload " +
                                std::to_string(payload));
  }
  // Whole packets, so that no read can overflow.
  const std::size_t unit = std::max(alignment, kPacket);
  StreamLayout layout;
  layout.leader = RoundUp(std::max<std::size_t>(leader, 1), unit);
  layout.trailer = RoundUp(std::max<std::size_t>(trailer, 1), unit);
  layout.payload = payload;
  layout.transfer = std::min(RoundUp(payload, unit), kLargestTransfer);
  layout.transfers = payload / layout.transfer;
  layout.last_transfer = RoundUp(payload % layout.transfer, unit);
  return layout;
}

std::size_t StreamReader::SizeOfRead(std::size_t index) const {
  if (index == 0) return layout_.leader;
  if (index <= layout_.transfers) return layout_.transfer;
  return index == layout_.transfers + 1 && layout_.last_transfer != 0 ? layout_.last_transfer : layout_.trailer;
}

void StreamReader::Fail(const std::string& cause) {
  port_.CancelReads();
  posted_.clear();
  throw DeviceError("camera", "read image", cause);
}

void StreamReader::Start() {
  port_.CancelReads();
  posted_.clear();
  posted_bytes_ = next_read_ = next_taken_ = 0;
  shifted_ = false;
  leader_.reset();
  payload_.clear();
  last_status_ = Status::kOk;
  Post();
}

void StreamReader::Post() {
  const std::size_t reads = layout_.transfers + (layout_.last_transfer != 0 ? 3 : 2);
  while (posted_.size() < 2 * reads) {
    const std::size_t size = SizeOfRead(next_read_);
    if (posted_bytes_ + size > kMostUnderWay) return;
    const auto spare = std::ranges::find(spare_, size, &Bytes::size);  // of this size: growing one would clear it first
    if (spare != spare_.end()) {
      posted_.push_back(std::move(*spare));
      spare_.erase(spare);
    } else {
      posted_.emplace_back(size);
    }
    last_status_ = port_.PostRead(posted_.back());
    if (last_status_ != Status::kOk) Fail("posting a read: " + std::string(UsbStatusWords(last_status_)));
    posted_bytes_ += size;
    next_read_ = (next_read_ + 1) % reads;
  }
}

std::optional<Frame> StreamReader::Take(ByteView data, std::size_t posted) {
  const std::size_t reads = layout_.transfers + (layout_.last_transfer != 0 ? 3 : 2);
  const std::size_t place = std::exchange(next_taken_, (next_taken_ + 1) % reads);
  std::string error;
  if (!leader_) {
    leader_ = DecodeLeader(data, error);
    if (!leader_) Fail(error);
    shifted_ = shifted_ || place != 0;
    payload_.clear();
    payload_.reserve(layout_.payload);
    return std::nullopt;
  }
  // A payload that ends early leaves its trailer in the read where the rest was to go.
  std::string no_trailer;
  const bool whole = payload_.size() >= layout_.payload;
  const std::optional<Trailer> trailer = DecodeTrailer(data, no_trailer);
  if (!whole && (!trailer || trailer->block_id != leader_->block_id)) {
    payload_.insert(payload_.end(), data.begin(), data.end());
    shifted_ = shifted_ || (data.size() < posted && payload_.size() < layout_.payload);
    return std::nullopt;
  }
  if (!trailer) Fail(no_trailer);
  shifted_ = shifted_ || place != reads - 1;
  Frame frame{*std::exchange(leader_, std::nullopt), *trailer, std::move(payload_)};
  payload_ = {};
  if (const std::string fault = FrameFault(frame.leader, frame.trailer, frame.payload.size()); !fault.empty())
    Fail(fault);
  if (last_block_ && frame.leader.block_id > *last_block_ + 1) missed_ += frame.leader.block_id - *last_block_ - 1;
  last_block_ = frame.leader.block_id;
  return frame;
}

Frame StreamReader::Next(std::chrono::milliseconds timeout, std::stop_token stop) {
  const Clock::time_point deadline = port_.Now() + timeout;
  while (true) {
    ThrowIfStopped(stop);
    if (posted_.empty()) Start();
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline - port_.Now());
    const std::optional<UsbPort::Result> result = port_.Reap(std::clamp(left, std::chrono::milliseconds(0), kGlance));
    if (!result) {
      if (left.count() > 0) continue;
      last_status_ = Status::kTimeout;
      throw TimeoutError("camera", "read image",
                         leader_ ? "the image did not end within " + std::to_string(timeout.count()) + " ms"
                                 : "no image within " + std::to_string(timeout.count()) + " ms",
                         "Check the trigger and that the laser shines");
    }
    last_status_ = result->status;
    if (result->status != Status::kOk) Fail(std::string(UsbStatusWords(result->status)));
    Bytes buffer = std::move(posted_.front());
    posted_.pop_front();
    posted_bytes_ -= buffer.size();
    std::optional<Frame> frame = Take(ByteView(buffer).first(result->size), buffer.size());
    spare_.push_back(std::move(buffer));
    if (frame) {
      if (shifted_) Start();  // so that each read again has the size of what comes
      Post();
      return *std::move(frame);
    }
    Post();
  }
}

void StreamReader::DiscardWaiting() {
  try {
    while (true) Next(std::chrono::milliseconds(0), {});
  } catch (const TimeoutError&) {
    if (leader_) Start();
  } catch (const DeviceError&) {
    if (last_status_ == Status::kGone) throw;
    if (last_status_ != Status::kOk) port_.ResetStream();
    Start();
  }
}

}  // namespace geond::drivers::u3v
