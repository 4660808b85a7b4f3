// SPDX-License-Identifier: Apache-2.0
#include "drivers/u3v_stream.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <iterator>
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

std::span<std::uint8_t> StreamReader::PlaceOfRead(Buffers& buffers, std::size_t index) const {
  if (index == 0) return buffers.leader;
  const std::size_t begin = (index - 1) * layout_.transfer;
  if (index <= layout_.transfers) return std::span(buffers.payload).subspan(begin, layout_.transfer);
  return index + 1 < reads() ? std::span(buffers.payload).subspan(begin, layout_.last_transfer) : buffers.trailer;
}

StreamReader::Buffers StreamReader::TakeSpare() {
  const std::size_t payload = layout_.transfers * layout_.transfer + layout_.last_transfer;
  if (spare_.empty()) return {Bytes(layout_.leader), Bytes(payload), Bytes(layout_.trailer)};
  Buffers buffers = std::move(spare_.back());
  spare_.pop_back();
  buffers.payload.resize(payload);
  return buffers;
}

void StreamReader::GiveBack(Frame frame) {
  // The last frame left its buffers without a payload.
  for (Buffers& buffers : spare_) {
    if (buffers.payload.empty()) {
      buffers.payload = std::move(frame.payload);
      return;
    }
  }
}

void StreamReader::Forget() {
  port_.CancelReads();
  std::ranges::move(frames_, std::back_inserter(spare_));
  frames_.clear();
  posted_ = posted_bytes_ = next_read_ = next_taken_ = taking_ = kept_ = received_ = 0;
}

void StreamReader::Fail(const std::string& cause) {
  Forget();
  throw DeviceError("camera", "read image", cause);
}

void StreamReader::Start() {
  Forget();
  shifted_ = false;
  leader_.reset();
  last_status_ = Status::kOk;
  Post();
}

void StreamReader::Post() {
  while (posted_ < 2 * reads()) {
    if (posted_bytes_ >= kMostUnderWay) return;
    if (next_read_ == 0) frames_.push_back(TakeSpare());
    const std::span<std::uint8_t> place = PlaceOfRead(frames_.back(), next_read_);
    last_status_ = port_.PostRead(place);
    if (last_status_ != Status::kOk) Fail("posting a read: " + std::string(UsbStatusWords(last_status_)));
    ++posted_;
    posted_bytes_ += place.size();
    next_read_ = (next_read_ + 1) % reads();
  }
}

std::optional<Frame> StreamReader::Take(std::size_t size) {
  const std::span<std::uint8_t> read = PlaceOfRead(frames_[taking_], next_taken_);
  const std::size_t place = next_taken_, in = taking_;
  --posted_;
  posted_bytes_ -= read.size();
  next_taken_ = (next_taken_ + 1) % reads();
  if (next_taken_ == 0) ++taking_;
  const ByteView data = read.first(size);
  std::string error;
  if (!leader_) {
    leader_ = DecodeLeader(data, error);
    if (!leader_) Fail(error);
    shifted_ = shifted_ || place != 0;
    kept_ = in;
    received_ = 0;
    return std::nullopt;
  }
  // A payload that ends early leaves its trailer in the read where the rest was to go.
  std::string no_trailer;
  const bool whole = received_ >= layout_.payload;
  const std::optional<Trailer> trailer = DecodeTrailer(data, no_trailer);
  Bytes& payload = frames_[kept_].payload;
  if (!whole && (!trailer || trailer->block_id != leader_->block_id)) {
    if (size > payload.size() - received_) Fail("a payload of more than " + std::to_string(layout_.payload) + " bytes");
    // Where it goes has been read and taken: what came before it was at most as much as was posted for it.
    if (payload.data() + received_ != data.data()) std::memmove(payload.data() + received_, data.data(), size);
    received_ += size;
    shifted_ = shifted_ || (size < read.size() && received_ < layout_.payload);
    return std::nullopt;
  }
  if (!trailer) Fail(no_trailer);
  shifted_ = shifted_ || place != reads() - 1;
  if (const std::string fault = FrameFault(*leader_, *trailer, received_); !fault.empty()) Fail(fault);
  payload.resize(received_);
  Frame frame{*std::exchange(leader_, std::nullopt), *trailer, std::exchange(payload, {})};
  for (; taking_ > 0; --taking_) {
    spare_.push_back(std::move(frames_.front()));
    frames_.pop_front();
  }
  if (last_block_ && frame.leader.block_id > *last_block_ + 1) missed_ += frame.leader.block_id - *last_block_ - 1;
  last_block_ = frame.leader.block_id;
  return frame;
}

Frame StreamReader::Next(std::chrono::milliseconds timeout, std::stop_token stop) {
  const Clock::time_point deadline = port_.Now() + timeout;
  while (true) {
    ThrowIfStopped(stop);
    if (posted_ == 0) Start();
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
    if (std::optional<Frame> frame = Take(result->size)) {
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
