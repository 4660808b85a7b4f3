// SPDX-License-Identifier: Apache-2.0
#include <deque>

#include "core/base/error.h"
#include "sim/fake_camera.h"

namespace geond::sim {
namespace {

using drivers::UsbPort;
using Status = UsbPort::Status;

class FakeCameraPort final : public UsbPort {
 public:
  explicit FakeCameraPort(std::shared_ptr<FakeCamera> camera) : camera_(std::move(camera)) {}

  std::string model() const override { return "FakeRange"; }
  std::string identity() const override { return camera_->serial(); }

  Result ControlOut(std::span<const std::uint8_t> data, std::chrono::milliseconds) override {
    std::vector<std::uint8_t> copy(data.begin(), data.end());
    return Move(FakeCamera::kControlOut, copy);
  }

  // As much time as was waited for in vain: a camera without a wire is not late because this machine stood still.
  std::chrono::steady_clock::time_point Now() const override { return now_; }

  // An answer that is not there by now never comes.
  Result ControlIn(std::span<std::uint8_t> buffer, std::chrono::milliseconds timeout) override {
    const Result result = Move(FakeCamera::kControlIn, buffer);
    if (result.status == Status::kTimeout) now_ += timeout;
    return result;
  }

  Status ClearControlHalt() override {
    camera_->SetHalt(FakeCamera::kControlIn, false);
    return Here();
  }

  bool Present() override { return camera_->plugged(); }

  Status PostRead(std::span<std::uint8_t> buffer) override {
    if (!camera_->plugged()) return Status::kGone;
    posted_.push_back(buffer);
    return Status::kOk;
  }

  std::optional<Result> Reap(std::chrono::milliseconds timeout) override {
    if (posted_.empty()) return std::nullopt;
    const auto end = std::chrono::steady_clock::now() + timeout;
    while (true) {
      const Result result = Move(FakeCamera::kStreamIn, posted_.front());
      if (result.status != Status::kTimeout) {
        posted_.pop_front();
        return result;
      }
      const auto left = end - std::chrono::steady_clock::now();
      if (left.count() <= 0) break;
      camera_->WaitForChange(std::chrono::ceil<std::chrono::milliseconds>(left));
    }
    now_ += timeout;
    return std::nullopt;
  }

  void CancelReads() noexcept override { posted_.clear(); }

  Status ResetStream() override {
    camera_->SetHalt(FakeCamera::kStreamIn, false);
    return Here();
  }

  Status ResetDevice() override {
    camera_->ResetDevice();
    return Here();
  }

 private:
  Status Here() const { return camera_->plugged() ? Status::kOk : Status::kGone; }

  Result Move(std::uint8_t endpoint, std::span<std::uint8_t> data) {
    if (!camera_->plugged()) return {Status::kGone, 0};
    const int count = camera_->Transfer(endpoint, data);
    if (count >= 0) return {Status::kOk, static_cast<std::size_t>(count)};
    if (count == FakeCamera::kNothingYet) return {Status::kTimeout, 0};
    return {count == FakeCamera::kStall ? Status::kStall : Status::kOverflow, 0};
  }

  const std::shared_ptr<FakeCamera> camera_;
  std::deque<std::span<std::uint8_t>> posted_;
  std::chrono::steady_clock::time_point now_{};
};

}  // namespace

std::unique_ptr<UsbPort> OpenFakeCamera(const std::shared_ptr<FakeCamera>& camera) {
  if (!camera->plugged()) {
    throw DeviceError("camera", "open", "it is unplugged", "Plug it in and reset the station");
  }
  return std::make_unique<FakeCameraPort>(camera);
}

}  // namespace geond::sim
