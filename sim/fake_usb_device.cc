// SPDX-License-Identifier: Apache-2.0
#include "sim/fake_usb_device.h"

#include <algorithm>
#include <iterator>
#include <string>

namespace geond::sim {
namespace {

using Bytes = std::vector<std::uint8_t>;

const Bytes kDevice = {18, 1, 0x00, 0x03, 0xef, 2, 1, 9, 0x09, 0x12, 0x01, 0x00, 0x00, 0x01, 1, 2, 3, 1};
const char* const kTexts[] = {"geond", "FakeRange", "FC0001", "GEON00FC0001"};
// USB 3's own: what the device can do besides; a kernel asks for it.
const Bytes kCapabilities = {5,  15, 22, 0, 2, 7,  16, 2, 0, 0, 0, 0,     // USB 2 extension: nothing
                             10, 16, 3,  0, 8, 0,  3, 10, 255, 7};        // SuperSpeed only

Bytes Configuration() {
  Bytes bytes;
  bytes.reserve(128);
  const auto add = [&bytes](std::initializer_list<std::uint8_t> more) { bytes.insert(bytes.end(), more); };
  add({9, 2, 0, 0, 2, 1, 0, 0x80, 112});
  add({8, 11, 0, 2, 0xef, 5, 0, 0});    // two interfaces that belong together
  add({9, 4, 0, 0, 2, 0xef, 5, 0, 0});  // control
  add({20, 0x24, 1, 0, 0, 1, 0, 0, 0, 1, 0, 4, 1, 2, 0, 0, 0, 3, 0, 8});
  add({7, 5, FakeCamera::kControlOut, 2, 0x00, 0x04, 0, 6, 0x30, 0, 0, 0, 0});
  add({7, 5, FakeCamera::kControlIn, 2, 0x00, 0x04, 0, 6, 0x30, 0, 0, 0, 0});
  add({9, 4, 1, 0, 1, 0xef, 5, 2, 0});  // stream
  add({7, 5, FakeCamera::kStreamIn, 2, 0x00, 0x04, 0, 6, 0x30, 15, 0, 0, 0});
  bytes[2] = static_cast<std::uint8_t>(bytes.size());
  bytes[3] = static_cast<std::uint8_t>(bytes.size() >> 8);
  return bytes;
}

Bytes Text(const std::string& text) {
  Bytes answer = {static_cast<std::uint8_t>(2 + 2 * text.size()), 3};
  for (char c : text) {
    answer.push_back(static_cast<std::uint8_t>(c));
    answer.push_back(0);
  }
  return answer;
}

}  // namespace

Bytes FakeUsbDescriptors() {
  Bytes bytes = kDevice;
  const Bytes configuration = Configuration();
  bytes.insert(bytes.end(), configuration.begin(), configuration.end());
  return bytes;
}

int FakeUsbControl(FakeCamera& camera, std::span<const std::uint8_t> setup, std::span<std::uint8_t> data) {
  constexpr std::uint8_t kGetStatus = 0, kClearFeature = 1, kSetFeature = 3, kGetDescriptor = 6, kGetConfiguration = 8,
                         kSetConfiguration = 9, kSetInterface = 11;
  const auto give = [&](const Bytes& answer) {
    const std::size_t count = std::min(data.size(), answer.size());
    std::copy_n(answer.begin(), count, data.begin());
    return static_cast<int>(count);
  };
  const std::uint8_t request = setup[1], type = setup[3], index = setup[2];
  if ((setup[0] & 0x60) != 0) return FakeCamera::kStall;
  switch (request) {
    case kGetDescriptor:
      if (type == 1) return give(kDevice);
      if (type == 2) return give(Configuration());
      if (type == 3 && index == 0) return give({4, 3, 0x09, 0x04});
      if (type == 3 && index <= std::size(kTexts)) return give(Text(kTexts[index - 1]));
      if (type == 15) return give(kCapabilities);
      return FakeCamera::kStall;
    case kGetStatus:
      return give({0, 0});
    case kGetConfiguration:
      return give({1});
    case kClearFeature:
    case kSetFeature:
      if ((setup[0] & 0x1f) == 2) camera.SetHalt(setup[4], request == kSetFeature);
      return 0;
    case kSetConfiguration:
    case kSetInterface:
      return 0;
    default:
      return FakeCamera::kStall;
  }
}

}  // namespace geond::sim
