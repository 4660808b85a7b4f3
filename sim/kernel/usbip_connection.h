// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <list>
#include <mutex>
#include <thread>
#include <vector>

#include "sim/fake_camera.h"

namespace geond::sim {

// The device's end of USB/IP (Linux' Documentation/usb/usbip_protocol): a fake camera that was imported already answers
// the requests that come over a stream socket. Transfers of one endpoint end in their order; one that has no data yet
// waits, and can be unlinked. Ends when the other side hangs up or sends what is no request.
class UsbipConnection {
 public:
  // Takes the socket over.
  UsbipConnection(FakeCamera& camera, int socket);
  ~UsbipConnection();  // hangs up: to the other side the device is unplugged
  UsbipConnection(const UsbipConnection&) = delete;
  UsbipConnection& operator=(const UsbipConnection&) = delete;

 private:
  struct Request {
    std::uint32_t number = 0;
    std::uint8_t endpoint = 0;  // with the direction's bit
    std::uint8_t setup[8] = {};
    std::vector<std::uint8_t> data;
  };
  void Serve();
  bool ServeOne();
  bool Complete(Request& request);
  void CompleteWaiting();
  void Unlink(std::uint32_t answer, std::uint32_t number);

  FakeCamera& camera_;
  const int socket_;
  std::mutex mutex_;  // of what waits, and of writing
  std::list<Request> waiting_;
  std::jthread ticker_, server_;
};

}  // namespace geond::sim
