// SPDX-License-Identifier: Apache-2.0
// The fake camera by USB/IP, with this test in the kernel's place: the bytes are those of Linux' usbip_protocol.
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "drivers/u3v_protocol.h"
#include "sim/fake_usb_device.h"
#include "sim/kernel/usbip_connection.h"

namespace geond::sim {
namespace {

using Bytes = std::vector<std::uint8_t>;
using testing::ElementsAre;

constexpr std::uint32_t kSubmit = 1, kUnlink = 2, kSubmitted = 3, kUnlinked = 4;
constexpr std::uint8_t kControl = 0, kControlOut = 1, kControlIn = 0x81, kStreamIn = 0x82;
const Bytes kNoSetup(8, 0);

SensorModel Sensor() {
  SensorModel sensor;
  sensor.columns = 16;
  sensor.rows = 8;
  sensor.focal_u = sensor.focal_v = 100.0;
  sensor.center_u = 7.5;
  sensor.center_v = 3.5;
  sensor.min_depth = 0.25;
  sensor.max_depth = 0.75;
  return sensor;
}

void Append(Bytes& bytes, std::uint32_t number) {
  for (int shift = 24; shift >= 0; shift -= 8) bytes.push_back(static_cast<std::uint8_t>(number >> shift));
}

struct Answer {
  std::uint32_t command = 0, number = 0;
  int status = 0;
  Bytes data;
};

class Usbip : public testing::Test {
 protected:
  Usbip() : camera_(Sensor(), [] { return std::nullopt; }) {
    int ends[2];
    EXPECT_EQ(socketpair(AF_UNIX, SOCK_STREAM, 0, ends), 0);
    kernel_ = ends[1];
    device_.emplace(camera_, ends[0]);
  }
  ~Usbip() override {
    device_.reset();
    close(kernel_);
  }

  void Send(const Bytes& bytes) {
    ASSERT_EQ(send(kernel_, bytes.data(), bytes.size(), MSG_NOSIGNAL), static_cast<ssize_t>(bytes.size()));
  }

  // `length`: of what is asked for, or of `data`.
  void Submit(std::uint32_t number, std::uint8_t endpoint, std::uint32_t length, const Bytes& data = {},
              const Bytes& setup = kNoSetup) {
    Bytes bytes;
    const bool in = (endpoint & 0x80) != 0;
    for (const std::uint32_t word : {kSubmit, number, 0x10002u, in ? 1u : 0u, endpoint & 0x7fu, 0u, length, 0u, 0u, 0u}) {
      Append(bytes, word);
    }
    bytes.insert(bytes.end(), setup.begin(), setup.end());
    bytes.insert(bytes.end(), data.begin(), data.end());
    Send(bytes);
  }

  void Unlink(std::uint32_t number, std::uint32_t meant) {
    Bytes bytes;
    for (const std::uint32_t word : {kUnlink, number, 0x10002u, 0u, 0u, meant, 0u, 0u, 0u, 0u, 0u, 0u}) Append(bytes, word);
    Send(bytes);
  }

  std::uint32_t ReadNumber(const Bytes& bytes, std::size_t word) {
    return static_cast<std::uint32_t>(bytes[4 * word]) << 24 | static_cast<std::uint32_t>(bytes[4 * word + 1]) << 16 |
           static_cast<std::uint32_t>(bytes[4 * word + 2]) << 8 | bytes[4 * word + 3];
  }

  // The next answer; `in`: the data of one that carries some follow it.
  Answer Receive(bool in = true) {
    Bytes header(48);
    EXPECT_EQ(recv(kernel_, header.data(), header.size(), MSG_WAITALL), 48);
    Answer answer{ReadNumber(header, 0), ReadNumber(header, 1), static_cast<int>(ReadNumber(header, 5)), {}};
    if (answer.command != kSubmitted || !in) return answer;
    answer.data.resize(ReadNumber(header, 6));
    if (!answer.data.empty()) {
      EXPECT_EQ(recv(kernel_, answer.data.data(), answer.data.size(), MSG_WAITALL),
                static_cast<ssize_t>(answer.data.size()));
    }
    return answer;
  }

  FakeCamera camera_;
  int kernel_ = -1;
  std::optional<UsbipConnection> device_;
};

TEST_F(Usbip, DescribesItselfOnEndpointZero) {
  const Bytes get_device = {0x80, 6, 0, 1, 0, 0, 18, 0}, get_configuration = {0x80, 6, 0, 2, 0, 0, 255, 0};
  Submit(1, kControl | 0x80, 18, {}, get_device);
  Bytes whole = Receive().data;
  Submit(2, kControl | 0x80, 255, {}, get_configuration);
  const Answer configuration = Receive();
  EXPECT_EQ(configuration.number, 2u);
  EXPECT_EQ(configuration.data[2] + 256 * configuration.data[3], static_cast<int>(configuration.data.size()));
  whole.insert(whole.end(), configuration.data.begin(), configuration.data.end());
  EXPECT_EQ(whole, FakeUsbDescriptors());
}

TEST_F(Usbip, WhatItDoesNotKnowIsStalledAndTheNextIsAnswered) {
  Submit(1, kControl | 0x80, 4, {}, {0xc0, 77, 0, 0, 0, 0, 4, 0});  // a vendor's request
  EXPECT_EQ(Receive().status, -EPIPE);
  Submit(2, kControl | 0x80, 2, {}, {0x80, 0, 0, 0, 0, 0, 2, 0});
  EXPECT_THAT(Receive().data, ElementsAre(0, 0));
}

TEST_F(Usbip, ARegisterIsReadByTwoTransfers) {
  Submit(1, kControlIn, 1024);  // posted before there is anything to read
  const Bytes ask = drivers::u3v::EncodeReadMem(7, 0, 4);
  Submit(2, kControlOut, static_cast<std::uint32_t>(ask.size()), ask);
  EXPECT_EQ(Receive(false).number, 2u);  // the command ends before its answer can
  const Answer first = Receive();
  EXPECT_EQ(first.number, 1u);
  EXPECT_EQ(first.data.size(), 16u);
  EXPECT_EQ(Bytes(first.data.begin(), first.data.begin() + 4), (Bytes{'U', '3', 'V', 'C'}));
}

TEST_F(Usbip, WhatWaitsCanBeUnlinkedAndLosesNothing) {
  Submit(1, kControlIn, 1024);
  Unlink(2, 1);
  const Answer unlinked = Receive();
  EXPECT_EQ(unlinked.command, kUnlinked);
  EXPECT_EQ(unlinked.number, 2u);
  EXPECT_EQ(unlinked.status, -ECONNRESET);
  const Bytes ask = drivers::u3v::EncodeReadMem(8, 0, 4);
  Submit(3, kControlOut, static_cast<std::uint32_t>(ask.size()), ask);
  EXPECT_EQ(Receive(false).number, 3u);
  Submit(4, kControlIn, 1024);
  EXPECT_EQ(Receive().data.size(), 16u);
  Unlink(5, 4);  // too late
  EXPECT_EQ(Receive().status, 0);
}

TEST_F(Usbip, AStallOfTheStreamStaysUntilItIsCleared) {
  camera_.SetHalt(kStreamIn, true);
  Submit(1, kStreamIn, 1024);
  EXPECT_EQ(Receive().status, -EPIPE);
  Submit(2, kControl, 0, {}, {0x02, 1, 0, 0, kStreamIn, 0, 0, 0});
  EXPECT_EQ(Receive(false).status, 0);
  Submit(3, kStreamIn, 1024);
  Unlink(4, 3);  // it waits now
  EXPECT_EQ(Receive().status, -ECONNRESET);
}

TEST_F(Usbip, HangsUpOnWhatIsNoRequest) {
  Send(Bytes(48, 0xff));
  char byte;
  EXPECT_EQ(recv(kernel_, &byte, 1, 0), 0);
}

TEST_F(Usbip, HangsUpOnATransferOfAbsurdLength) {
  Submit(1, kControlOut, 0xfffffff0u);
  char byte;
  EXPECT_EQ(recv(kernel_, &byte, 1, 0), 0);
}

}  // namespace
}  // namespace geond::sim
