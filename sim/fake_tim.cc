// SPDX-License-Identifier: Apache-2.0
#include "sim/fake_tim.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/error.h"

namespace geond::sim {
namespace {

namespace cola = drivers::cola;
using drivers::UsbPort;
using Status = UsbPort::Status;

constexpr std::chrono::microseconds kLineTime(66'667);  // 15 Hz
constexpr double kFarthest = 10.0;           // m

class FakeTimPort final : public UsbPort {
 public:
  explicit FakeTimPort(std::shared_ptr<FakeTim> scanner) : scanner_(std::move(scanner)) {}
  std::string model() const override { return "TiM5xx"; }
  std::string identity() const override { return scanner_->serial(); }
  Result ControlOut(std::span<const std::uint8_t> data, std::chrono::milliseconds) override {
    if (!Present()) return {Status::kGone, 0};
    scanner_->Receive(data);
    return {Status::kOk, data.size()};
  }
  std::chrono::steady_clock::time_point Now() const override {
    return std::chrono::steady_clock::time_point(scanner_->now());
  }
  Result ControlIn(std::span<std::uint8_t> buffer, std::chrono::milliseconds timeout) override {
    if (!Present()) return {Status::kGone, 0};
    const cola::Bytes said = scanner_->Send(timeout);
    if (said.empty()) return {Status::kTimeout, 0};
    if (said.size() > buffer.size()) return {Status::kOverflow, 0};
    std::copy(said.begin(), said.end(), buffer.begin());
    return {Status::kOk, said.size()};
  }
  Status ClearControlHalt() override { return Status::kOk; }
  bool Present() override { return !scanner_->faults().unplugged; }
  Status PostRead(std::span<std::uint8_t>) override { return Status::kFailed; }  // it has no stream
  std::optional<Result> Reap(std::chrono::milliseconds) override { return std::nullopt; }
  void CancelReads() noexcept override {}
  Status ResetStream() override { return Status::kFailed; }
  Status ResetDevice() override { return Present() ? Status::kOk : Status::kGone; }

 private:
  const std::shared_ptr<FakeTim> scanner_;
};

}  // namespace

void FakeTim::Say(const std::string& text, cola::ByteView binary) {
  const cola::Bytes telegram = cola::Encode(protocol_, text, binary);
  answers_.insert(answers_.end(), telegram.begin(), telegram.end());
}

void FakeTim::Obey(const cola::Telegram& telegram) {
  const bool binary = protocol_ == cola::Protocol::kB;
  const std::string kind(telegram.kind()), name(telegram.name());
  const auto say = [&](const std::string& text, int value) {
    const cola::Bytes number = {static_cast<std::uint8_t>(value)};
    binary ? Say(text + " ", number) : Say(text + " " + std::to_string(value));
  };
  if (faults_.refuses) return say("sFA", 5);
  if (kind == "sRN" && name == "SCdevicestate") return say("sRA SCdevicestate", 1);
  if (kind == "sMN" && (name == "SetAccessMode" || name == "Run")) return say("sAN " + name, 1);
  if (kind == "sEN" && name == "LMDscandata") {
    const std::uint8_t last = telegram.content.back();
    scanning_ = binary ? last == 1 : last == '1';
    next_line_ = now_ + kLineTime;
    return say("sEA LMDscandata", scanning_);
  }
  say("sFA", 3);
}

void FakeTim::Receive(cola::ByteView data) {
  const std::lock_guard lock(mutex_);
  if (faults_.silent) return;
  received_.insert(received_.end(), data.begin(), data.end());
  int broken = 0;
  while (const auto telegram = cola::TakeTelegram(received_, broken)) {
    if (telegram->protocol == protocol_) Obey(*telegram);  // it is deaf to the other
  }
}

cola::Bytes FakeTim::Send(std::chrono::microseconds wait) {
  const std::lock_guard lock(mutex_);
  if (!faults_.silent && !answers_.empty()) return std::exchange(answers_, {});
  const std::chrono::microseconds end = now_ + wait;
  while (scanning_ && !faults_.silent && next_line_ <= end) {
    now_ = std::exchange(next_line_, next_line_ + kLineTime);
    ++lines_;
    if (faults_.lost_lines == 0) return Line();
    --faults_.lost_lines;
  }
  now_ = end;
  return {};
}

cola::Bytes FakeTim::Line() {
  cola::ScanLine line;
  line.telegram_counter = line.scan_counter = lines_ & 0xffff;
  line.start_us = static_cast<std::uint32_t>(now_.count());
  line.status = faults_.status;
  line.scan_frequency = 15.0;
  line.first_angle = kFirstAngle;
  line.step = kStep;
  line.range = take_();
  line.remission.assign(line.range.size(), 200);
  const cola::Telegram telegram = cola::EncodeScanLine(line, protocol_);
  cola::Bytes framed = protocol_ == cola::Protocol::kA
                           ? cola::Encode(protocol_, std::string(telegram.content.begin(), telegram.content.end()))
                           : cola::Encode(protocol_, "", telegram.content);
  if (faults_.broken_lines > 0) {
    --faults_.broken_lines;
    if (protocol_ == cola::Protocol::kB) {
      framed.back() ^= 0x55;
    } else {
      framed.erase(framed.begin() + 100, framed.end() - 1);  // the end of a line without its middle
    }
  }
  return framed;
}

void FakeTim::SetFaults(const FakeTimFaults& faults) {
  const std::lock_guard lock(mutex_);
  faults_ = faults;
}

FakeTimFaults FakeTim::faults() const {
  const std::lock_guard lock(mutex_);
  return faults_;
}

std::chrono::microseconds FakeTim::now() const {
  const std::lock_guard lock(mutex_);
  return now_;
}

bool FakeTim::scanning() const {
  const std::lock_guard lock(mutex_);
  return scanning_;
}

std::unique_ptr<UsbPort> OpenFakeTim(const std::shared_ptr<FakeTim>& scanner) {
  if (scanner->faults().unplugged) throw DeviceError("scanner", "open", "none is there, it is unplugged", "Plug it in");
  return std::make_unique<FakeTimPort>(scanner);
}

std::vector<float> TakeScanLine(const SceneGeometry& scene, const Pose& X_TS) {
  std::vector<float> ranges;
  const double middle = FakeTim::kFirstAngle + 0.5 * (FakeTim::kReadings - 1) * FakeTim::kStep;
  for (int i = 0; i < FakeTim::kReadings; ++i) {
    const double angle = FakeTim::kFirstAngle + i * FakeTim::kStep - middle;  // to the left
    const Eigen::Vector3d direction_S(-std::sin(angle), 0.0, std::cos(angle));
    const SceneGeometry::Hit hit =
        scene.Cast({X_TS.translation(), X_TS.rotation() * direction_S}, Eigen::Vector3d::Zero());
    ranges.push_back(hit.t < kFarthest ? static_cast<float>(1e-3 * std::round(1e3 * hit.t))
                                       : std::numeric_limits<float>::quiet_NaN());
  }
  return ranges;
}

}  // namespace geond::sim
