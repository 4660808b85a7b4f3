// SPDX-License-Identifier: Apache-2.0
#include "drivers/u3v_control.h"

#include <algorithm>

#include "core/base/error.h"
#include "drivers/little_endian.h"

namespace geond::drivers {

std::string_view UsbStatusWords(UsbPort::Status status) {
  switch (status) {
    case UsbPort::Status::kOk: return "ok";
    case UsbPort::Status::kTimeout: return "no answer in time";
    case UsbPort::Status::kStall: return "the endpoint stalled";
    case UsbPort::Status::kOverflow: return "more data than fits";
    case UsbPort::Status::kGone: return "it is unplugged";
    case UsbPort::Status::kCancelled: return "cancelled";
    case UsbPort::Status::kFailed: return "the transfer failed";
  }
  return "unknown";
}

namespace u3v {
namespace {

using Status = UsbPort::Status;
using Clock = std::chrono::steady_clock;

constexpr std::uint64_t kResponseTime = 0x01cc, kTransportRegisters = 0x01d8;
constexpr std::uint64_t kMaxCommand = 0x14, kMaxAcknowledge = 0x18, kStreamRegisters = 0x20;
constexpr std::uint16_t kBusy = 0x8007, kDeviceTimeout = 0x800B;
constexpr std::size_t kPacket = 1024;  // of USB 3; a whole number of them never overflows

}  // namespace

Ack ControlChannel::Transact(Command command, std::uint64_t address, ByteView data, std::size_t count) {
  const std::string call =
      (command == Command::kReadMem ? "read register " : "write register ") + std::to_string(address);
  Bytes buffer((max_acknowledge_ + kPacket - 1) / kPacket * kPacket);
  std::string cause = "no answer in time";
  for (int attempt = 0; attempt < options_.tries; ++attempt) {
    if (attempt > 0) ++repeats_;
    if (++request_id_ == 0) request_id_ = 1;
    const Bytes packet = command == Command::kReadMem
                             ? EncodeReadMem(request_id_, address, static_cast<std::uint16_t>(count))
                             : EncodeWriteMem(request_id_, address, data);
    UsbPort::Result result = port_.ControlOut(packet, response_time_);
    Clock::time_point deadline = port_.Now() + response_time_;
    while (result.status == Status::kOk) {
      const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline - port_.Now());
      if (left.count() <= 0) {
        result.status = Status::kTimeout;
        break;
      }
      result = port_.ControlIn(buffer, left);
      if (result.status != Status::kOk) break;
      Ack ack = DecodeAck(ByteView(buffer).first(result.size), command, request_id_, count);
      if (ack.kind == Ack::Kind::kAnswer) return ack;
      if (ack.kind == Ack::Kind::kStale) continue;
      if (ack.kind == Ack::Kind::kPending) {
        deadline = port_.Now() + std::chrono::milliseconds(ack.pending_ms);
        continue;
      }
      cause = ack.error;
      if (ack.kind == Ack::Kind::kRefused && ack.status != kBusy && ack.status != kDeviceTimeout) {
        throw DeviceError("camera", call, "refused: " + cause);
      }
      break;
    }
    if (result.status == Status::kGone) {
      throw DeviceError("camera", call, "it is unplugged", "Plug it in and reset the station");
    }
    if (result.status != Status::kOk) cause = UsbStatusWords(result.status);
    if (result.status == Status::kStall || result.status == Status::kOverflow) port_.ClearControlHalt();
  }
  throw TimeoutError("camera", call, cause + ", " + std::to_string(options_.tries) + " times",
                     "Check the cable, or unplug the camera and plug it in again");
}

Bytes ControlChannel::Read(std::uint64_t address, std::size_t count) {
  const std::size_t most = std::min<std::size_t>(max_acknowledge_ - kControlHeaderSize, 0xfff0);
  Bytes bytes;
  bytes.reserve(count);
  while (bytes.size() < count) {
    const std::size_t part = std::min(most, count - bytes.size());
    const Ack ack = Transact(Command::kReadMem, address + bytes.size(), {}, part);
    bytes.insert(bytes.end(), ack.data.begin(), ack.data.end());
  }
  return bytes;
}

void ControlChannel::Write(std::uint64_t address, ByteView data) {
  const std::size_t most = max_command_ - kControlHeaderSize - 8;
  for (std::size_t done = 0; done < data.size();) {
    const std::size_t part = std::min(most, data.size() - done);
    Transact(Command::kWriteMem, address + done, data.subspan(done, part), part);
    done += part;
  }
}

std::uint32_t ControlChannel::Read32(std::uint64_t address) {
  return ReadLittleEndian<std::uint32_t>(Read(address, 4), 0);
}
std::uint64_t ControlChannel::Read64(std::uint64_t address) {
  return ReadLittleEndian<std::uint64_t>(Read(address, 8), 0);
}

std::string ControlChannel::ReadText(std::uint64_t address, std::size_t count) {
  const Bytes bytes = Read(address, count);
  return std::string(bytes.begin(), std::ranges::find(bytes, 0));
}

void ControlChannel::Write32(std::uint64_t address, std::uint32_t value) {
  Bytes bytes;
  AppendLittleEndian(value, bytes);
  Write(address, bytes);
}

void ControlChannel::Negotiate() {
  const std::chrono::milliseconds own(Read32(kResponseTime));
  response_time_ =
      std::clamp(own, options_.response_time, std::max(options_.response_time, options_.longest_response_time));
  const std::uint64_t transport = Read64(kTransportRegisters);
  const std::size_t command = Read32(transport + kMaxCommand), acknowledge = Read32(transport + kMaxAcknowledge);
  stream_registers_ = Read64(transport + kStreamRegisters);
  if (command < 32 || acknowledge < 32) {
    throw DeviceError("camera", "open", "it says that a command has at most " + std::to_string(command) +
                                            " bytes and an answer " + std::to_string(acknowledge));
  }
  max_command_ = std::min<std::size_t>(command, 0xffff);
  max_acknowledge_ = std::min<std::size_t>(acknowledge, 0xffff);
}

}  // namespace u3v
}  // namespace geond::drivers
