// SPDX-License-Identifier: Apache-2.0
#include "sim/fake_camera.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "drivers/little_endian.h"
#include "drivers/u3v_protocol.h"
#include "sim/fake_camera_registers.h"

namespace geond::sim {
namespace {

using namespace fake_camera;
namespace u3v = drivers::u3v;
using drivers::AppendLittleEndian;
using drivers::ReadLittleEndian;

constexpr std::size_t kLongestTransfer = 1024;  // of control
constexpr std::uint16_t kPendingTime = 20;      // ms

}  // namespace

FakeCamera::FakeCamera(const SensorModel& sensor, std::function<std::optional<RangeImage>()> take, std::string serial)
    : sensor_(sensor), take_(std::move(take)), serial_(std::move(serial)), memory_(kMemoryEnd) {
  Put(0, 0x00010000, 4);
  PutText(0x04, "geond");
  PutText(0x44, "FakeRange");
  PutText(0xc4, "1");
  PutText(0x144, serial_);
  Put(0x1cc, 100, 4);
  Put(0x1d0, kManifest, 8);
  Put(0x1d8, kTransport, 8);
  Put(kTransport, 0x00010000, 4);
  Put(kTransport + 0x04, 1, 8);
  Put(kTransport + 0x14, kLongestTransfer, 4);
  Put(kTransport + 0x18, kLongestTransfer, 4);
  Put(kTransport + 0x1c, 1, 4);
  Put(kTransport + 0x20, kStream, 8);
  Put(kTransport + 0x28, 0x30, 4);
  Put(kTransport + 0x40, 8, 4);
  Put(kStream, 10u << 24, 4);
  Put(kStream + 0x10, 52, 4);
  Put(kStream + 0x14, 32, 4);
  const std::string xml = FakeCameraDescription(kFeatures, sensor_);
  std::copy(xml.begin(), xml.end(), memory_.begin() + kDescription);
  Put(kManifest, 1, 8);
  Put(kManifest + 8, 0x01000000, 4);
  Put(kManifest + 12, 0x01010000, 4);
  Put(kManifest + 16, kDescription, 8);
  Put(kManifest + 24, xml.size(), 8);
  Put(kFeatures + kWidth, static_cast<std::uint64_t>(sensor_.columns), 4);
  Put(kFeatures + kHeight, static_cast<std::uint64_t>(sensor_.rows), 4);
  Put(kFeatures + kPixelFormat, static_cast<std::uint64_t>(u3v::PixelFormat::kCoord3dC16), 4);
  Put(kFeatures + kInvalidFlag, 1, 4);
  const auto real = [this](std::uint64_t at, double value) {
    Put(kFeatures + at, std::bit_cast<std::uint64_t>(value), 8);
  };
  real(kFocalLength, sensor_.focal_u);
  real(kPrincipalU, sensor_.center_u);
  real(kPrincipalV, sensor_.center_v);
  real(kAxisMin, sensor_.min_depth * 1e3);
  real(kAxisMax, sensor_.max_depth * 1e3);
  UpdatePayloadSize();
}

std::uint64_t FakeCamera::Get(std::uint64_t address, std::size_t size) const {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < size; ++i) value |= std::uint64_t{memory_[address + i]} << (8 * i);
  return value;
}

void FakeCamera::Put(std::uint64_t address, std::uint64_t value, std::size_t size) {
  for (std::size_t i = 0; i < size; ++i) memory_[address + i] = static_cast<std::uint8_t>(value >> (8 * i));
}

void FakeCamera::PutText(std::uint64_t address, const std::string& text) {
  std::copy_n(text.begin(), std::min<std::size_t>(text.size(), 63),
              memory_.begin() + static_cast<std::ptrdiff_t>(address));
}

void FakeCamera::UpdatePayloadSize() {
  const std::uint64_t format = Get(kFeatures + kPixelFormat, 4);
  const std::uint64_t size = Get(kFeatures + kWidth, 4) * Get(kFeatures + kHeight, 4) * ((format >> 16) & 0xff) / 8 +
                             (chunks_ ? kChunkBytes : 0);
  Put(kFeatures + kPayloadSize, size, 4);
  Put(kStream + 0x08, size, 8);
  // Whole numbers count steps of 0.02 mm with 0 for nothing; floating point is in metres, so that no bit is lost.
  const bool whole = IsWholeNumber(format);
  const double scale = whole ? 1e3 / kUnitsPerMetre16 : 1e3;
  Put(kFeatures + kScale, std::bit_cast<std::uint64_t>(scale), 8);
  Put(kFeatures + kOffset, 0, 8);
  Put(kFeatures + kInvalidValue, std::bit_cast<std::uint64_t>(0.0), 8);
}

void FakeCamera::StopAcquisition() {
  acquiring_ = false;
  stream_.clear();
  free_payload_.clear();
  stream_at_ = 0;
}

void FakeCamera::Acknowledge(std::uint16_t status, std::uint16_t command, std::uint16_t id,
                             std::span<const std::uint8_t> data) {
  Bytes packet;
  AppendLittleEndian(TakeOne(faults_.broken_acknowledges) ? 0xdeadbeef : u3v::kControlMagic, packet);
  AppendLittleEndian(status, packet);
  AppendLittleEndian(command, packet);
  AppendLittleEndian(static_cast<std::uint16_t>(data.size()), packet);
  AppendLittleEndian(id, packet);
  packet.insert(packet.end(), data.begin(), data.end());
  if (TakeOne(faults_.stale_acknowledges) && !last_acknowledge_.empty()) acknowledges_.push_back(last_acknowledge_);
  last_acknowledge_ = packet;
  if (TakeOne(faults_.short_acknowledges)) packet.erase(packet.end() - 2, packet.end());
  acknowledges_.push_back(std::move(packet));
}

int FakeCamera::Command(std::span<const std::uint8_t> packet) {
  const int size = static_cast<int>(packet.size());
  if (TakeOne(faults_.control_stalls)) {
    control_halted_ = true;
    return kStall;
  }
  if (packet.size() < 20 || ReadLittleEndian<std::uint32_t>(packet, 0) != u3v::kControlMagic) {
    control_halted_ = true;
    return kStall;
  }
  const auto command = ReadLittleEndian<std::uint16_t>(packet, 6);
  const auto id = ReadLittleEndian<std::uint16_t>(packet, 10);
  const auto address = ReadLittleEndian<std::uint64_t>(packet, 12);
  const auto answer = static_cast<std::uint16_t>(command + 1);
  if (TakeOne(faults_.pending_acknowledges)) {
    const Bytes time = {0, 0, kPendingTime, 0};
    Acknowledge(0, u3v::kPendingAck, id, time);
  }
  if (TakeOne(faults_.busy_answers)) {
    Acknowledge(0x8007, answer, id, {});
    return size;
  }
  const bool lost = TakeOne(faults_.lost_acknowledges);  // the command is carried out all the same
  const std::size_t before = acknowledges_.size();
  if (command == static_cast<std::uint16_t>(u3v::Command::kReadMem) && packet.size() >= 24) {
    const std::size_t count = ReadLittleEndian<std::uint16_t>(packet, 22);
    if (count + 12 > kLongestTransfer) {
      Acknowledge(0x8002, answer, id, {});
    } else if (address >= kMemoryEnd || count > kMemoryEnd - address) {
      Acknowledge(0x8003, answer, id, {});
    } else {
      Acknowledge(0, answer, id, std::span(memory_).subspan(address, count));
    }
  } else if (command == static_cast<std::uint16_t>(u3v::Command::kWriteMem)) {
    const std::span<const std::uint8_t> data = packet.subspan(20);
    const bool writable = (address >= kStream && address < kManifest) || address >= kFeatures;
    if (address >= kMemoryEnd || data.size() > kMemoryEnd - address) {
      Acknowledge(0x8003, answer, id, {});
    } else if (!writable) {
      Acknowledge(0x8004, answer, id, {});
    } else {
      std::copy(data.begin(), data.end(), memory_.begin() + static_cast<std::ptrdiff_t>(address));
      Written(address, data.size());
      const Bytes count = {0, 0, static_cast<std::uint8_t>(data.size()), static_cast<std::uint8_t>(data.size() >> 8)};
      Acknowledge(0, answer, id, count);
    }
  } else {
    Acknowledge(0x8001, answer, id, {});
  }
  if (lost) acknowledges_.resize(before);
  return size;
}

void FakeCamera::Written(std::uint64_t address, std::size_t size) {
  const auto hit = [&](std::uint64_t feature) {
    return address <= kFeatures + feature && kFeatures + feature < address + size;
  };
  if (hit(kWidth) || hit(kHeight) || hit(kPixelFormat)) UpdatePayloadSize();
  if (hit(kAcquisition)) {
    acquiring_ = Get(kFeatures + kAcquisition, 4) == 1;
    if (!acquiring_) StopAcquisition();
  }
  if (hit(kTriggerSoftware)) Trigger(false);
}

void FakeCamera::Trigger(bool wire) {
  const bool listens = Get(kFeatures + kTriggerMode, 4) == 1 && (Get(kFeatures + kTriggerSource, 4) == 1) == wire;
  const bool streams = (Get(kStream + 0x04, 4) & 1) != 0;
  if (!acquiring_ || !listens || !streams) return;
  SendFrame();
}

int FakeCamera::Transfer(std::uint8_t endpoint, std::span<std::uint8_t> data) {
  const std::lock_guard lock(mutex_);
  if (faults_.silent) return endpoint == kControlOut ? static_cast<int>(data.size()) : kNothingYet;
  if (endpoint == kControlOut) {
    if (control_halted_) return kStall;
    const int result = Command(data);
    ++changes_;
    changed_.notify_all();
    return result;
  }
  if (endpoint == kStreamIn) return stream_halted_ ? kStall : ReadStream(data);
  if (control_halted_) return kStall;
  if (acknowledges_.empty()) return kNothingYet;
  const Bytes acknowledge = std::move(acknowledges_.front());
  acknowledges_.pop_front();
  if (acknowledge.size() > data.size()) return kOverflow;
  std::copy(acknowledge.begin(), acknowledge.end(), data.begin());
  return static_cast<int>(acknowledge.size());
}

void FakeCamera::SetHalt(std::uint8_t endpoint, bool halted) {
  const std::lock_guard lock(mutex_);
  if (endpoint == kStreamIn) {
    stream_halted_ = halted;
    stream_.clear();
    stream_at_ = 0;
  } else {
    control_halted_ = halted;
    acknowledges_.clear();
  }
}

void FakeCamera::ResetDevice() {
  const std::lock_guard lock(mutex_);
  StopAcquisition();
  acknowledges_.clear();
  Put(kStream + 0x04, 0, 4);
  Put(kFeatures + kLocked, 0, 4);
  control_halted_ = stream_halted_ = false;
}

void FakeCamera::WireTrigger() {
  const std::lock_guard lock(mutex_);
  Trigger(true);
  ++changes_;
  changed_.notify_all();
}

void FakeCamera::SetFaults(const FakeCameraFaults& faults) {
  const std::lock_guard lock(mutex_);
  faults_ = faults;
}

FakeCameraFaults FakeCamera::faults() const {
  const std::lock_guard lock(mutex_);
  return faults_;
}

void FakeCamera::SetPlugged(bool plugged) {
  if (!plugged) ResetDevice();
  const std::lock_guard lock(mutex_);
  plugged_ = plugged;
  ++changes_;
  changed_.notify_all();
}

bool FakeCamera::plugged() const {
  const std::lock_guard lock(mutex_);
  return plugged_;
}

void FakeCamera::WaitForChange(std::chrono::milliseconds timeout) {
  std::unique_lock lock(mutex_);
  Clock::time_point end = Clock::now() + timeout;
  if (!stream_.empty() && !stream_.front().told) end = std::min(end, stream_.front().ready);
  changed_.wait_until(lock, end, [this] { return changes_ != seen_changes_; });
  seen_changes_ = changes_;
  if (!stream_.empty()) stream_.front().told = stream_.front().ready <= Clock::now();
}

void FakeCamera::SetChunks(bool chunks) {
  const std::lock_guard lock(mutex_);
  chunks_ = chunks;
  Put(kStream + 0x14, chunks ? 36 : 32, 4);
  UpdatePayloadSize();
}

void FakeCamera::SetExposureTime(std::chrono::milliseconds time) {
  const std::lock_guard lock(mutex_);
  exposure_time_ = time;
}

bool FakeCamera::acquiring() const {
  const std::lock_guard lock(mutex_);
  return acquiring_;
}

std::uint64_t FakeCamera::frames() const {
  const std::lock_guard lock(mutex_);
  return frames_;
}

}  // namespace geond::sim
