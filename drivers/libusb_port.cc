// SPDX-License-Identifier: Apache-2.0
#include "drivers/libusb_port.h"

#include <libusb.h>

#include <algorithm>
#include <array>
#include <deque>
#include <vector>

#include "core/base/error.h"

namespace geond::drivers {
namespace {

using Status = UsbPort::Status;
using Clock = std::chrono::steady_clock;

constexpr std::uint8_t kMiscellaneous = 0xEF, kU3vSubclass = 0x05, kControlProtocol = 0x00, kStreamProtocol = 0x02;
constexpr std::uint8_t kU3vDescriptor = 0x24;
constexpr std::uint16_t kEndpointHalt = 0;
constexpr std::uint8_t kToEndpoint = 0x02;  // a standard request to an endpoint, without data
constexpr unsigned kRequestTimeout = 500;  // ms

struct FreeContext { void operator()(libusb_context* context) const { libusb_exit(context); } };
struct CloseHandle { void operator()(libusb_device_handle* handle) const { libusb_close(handle); } };
struct FreeConfig {
  void operator()(libusb_config_descriptor* config) const { libusb_free_config_descriptor(config); }
};
struct FreeTransfer { void operator()(libusb_transfer* transfer) const { libusb_free_transfer(transfer); } };
using Context = std::unique_ptr<libusb_context, FreeContext>;
using Handle = std::unique_ptr<libusb_device_handle, CloseHandle>;

Status StatusOf(int error) {
  switch (error) {
    case LIBUSB_SUCCESS: return Status::kOk;
    case LIBUSB_ERROR_TIMEOUT: return Status::kTimeout;
    case LIBUSB_ERROR_PIPE: return Status::kStall;
    case LIBUSB_ERROR_OVERFLOW: return Status::kOverflow;
    case LIBUSB_ERROR_NO_DEVICE:
    case LIBUSB_ERROR_NOT_FOUND: return Status::kGone;
    default: return Status::kFailed;
  }
}

Status StatusOf(libusb_transfer_status status) {
  switch (status) {
    case LIBUSB_TRANSFER_COMPLETED: return Status::kOk;
    case LIBUSB_TRANSFER_TIMED_OUT: return Status::kTimeout;
    case LIBUSB_TRANSFER_STALL: return Status::kStall;
    case LIBUSB_TRANSFER_OVERFLOW: return Status::kOverflow;
    case LIBUSB_TRANSFER_NO_DEVICE: return Status::kGone;
    case LIBUSB_TRANSFER_CANCELLED: return Status::kCancelled;
    case LIBUSB_TRANSFER_ERROR: return Status::kFailed;
  }
  return Status::kFailed;
}

timeval TimeOf(std::chrono::milliseconds time) {
  return {static_cast<time_t>(time.count() / 1000), static_cast<suseconds_t>(time.count() % 1000 * 1000)};
}

constexpr std::uint16_t kSickVendor = 0x19A2, kTimProduct = 0x5001;

// Where a device's channels are. A scanner has no stream.
struct Channels {
  int control_interface = -1, stream_interface = -1;
  std::uint8_t control_out = 0, control_in = 0, stream_in = 0;
  std::uint8_t guid_text = 0, model_text = 0, serial_text = 0;  // numbers of strings
  bool has_control() const { return control_interface >= 0 && control_out != 0 && control_in != 0; }
  bool has_stream() const { return stream_interface >= 0 && stream_in != 0; }
};

void ReadU3vDescriptor(const unsigned char* bytes, int size, Channels& channels) {
  for (int at = 0; at + 2 <= size && bytes[at] >= 2 && at + bytes[at] <= size; at += bytes[at]) {
    if (bytes[at + 1] != kU3vDescriptor || bytes[at] < 20 || bytes[at + 2] != 0x01) continue;
    channels.guid_text = bytes[at + 11];
    channels.model_text = bytes[at + 13];
    channels.serial_text = bytes[at + 17];
  }
}

// Of a camera; without control if it is none.
Channels CameraChannels(libusb_device* device) {
  Channels channels;
  libusb_config_descriptor* raw = nullptr;
  if (libusb_get_active_config_descriptor(device, &raw) != 0) return channels;
  const std::unique_ptr<libusb_config_descriptor, FreeConfig> config(raw);
  for (int i = 0; i < config->bNumInterfaces; ++i) {
    if (config->interface[i].num_altsetting < 1) continue;
    const libusb_interface_descriptor& setting = config->interface[i].altsetting[0];
    if (setting.bInterfaceClass != kMiscellaneous || setting.bInterfaceSubClass != kU3vSubclass) continue;
    const bool control = setting.bInterfaceProtocol == kControlProtocol;
    if (!control && setting.bInterfaceProtocol != kStreamProtocol) continue;
    (control ? channels.control_interface : channels.stream_interface) = setting.bInterfaceNumber;
    if (control) ReadU3vDescriptor(setting.extra, setting.extra_length, channels);
    for (int e = 0; e < setting.bNumEndpoints; ++e) {
      const libusb_endpoint_descriptor& endpoint = setting.endpoint[e];
      if ((endpoint.bmAttributes & 3) != LIBUSB_TRANSFER_TYPE_BULK) continue;
      const bool in = (endpoint.bEndpointAddress & LIBUSB_ENDPOINT_IN) != 0;
      if (control) (in ? channels.control_in : channels.control_out) = endpoint.bEndpointAddress;
      if (!control && in) channels.stream_in = endpoint.bEndpointAddress;
    }
  }
  return channels.has_stream() ? channels : Channels{};
}

// Of a SICK TiM, which has one interface with one endpoint each way; without control if it is none.
Channels ScannerChannels(libusb_device* device) {
  Channels channels;
  libusb_device_descriptor about{};
  libusb_config_descriptor* raw = nullptr;
  if (libusb_get_device_descriptor(device, &about) != 0 || about.idVendor != kSickVendor || about.idProduct != kTimProduct ||
      libusb_get_active_config_descriptor(device, &raw) != 0) {
    return channels;
  }
  const std::unique_ptr<libusb_config_descriptor, FreeConfig> config(raw);
  if (config->bNumInterfaces < 1 || config->interface[0].num_altsetting < 1) return channels;
  const libusb_interface_descriptor& setting = config->interface[0].altsetting[0];
  channels.control_interface = setting.bInterfaceNumber;
  channels.model_text = about.iProduct;
  channels.serial_text = about.iSerialNumber;
  for (int e = 0; e < setting.bNumEndpoints; ++e) {
    if ((setting.endpoint[e].bmAttributes & 3) != LIBUSB_TRANSFER_TYPE_BULK) continue;
    const std::uint8_t address = setting.endpoint[e].bEndpointAddress;
    ((address & LIBUSB_ENDPOINT_IN) != 0 ? channels.control_in : channels.control_out) = address;
  }
  return channels;
}

std::string TextOf(libusb_device_handle* handle, std::uint8_t number) {
  if (number == 0) return {};
  std::array<unsigned char, 256> text{};
  const int size = libusb_get_string_descriptor_ascii(handle, number, text.data(), text.size());
  return size > 0 ? std::string(text.begin(), text.begin() + size) : std::string();
}

[[noreturn]] void FailOpen(const std::string& thing, const std::string& cause, const std::string& remedy) {
  throw DeviceError(thing, "open", cause, remedy);
}

class LibusbPort final : public UsbPort {
 public:
  LibusbPort(const std::string& thing, Context context, Handle handle, const Channels& channels, std::string model,
             std::string identity)
      : context_(std::move(context)), handle_(std::move(handle)), channels_(channels), model_(std::move(model)),
        identity_(std::move(identity)) {
    libusb_set_auto_detach_kernel_driver(handle_.get(), 1);
    if (libusb_has_capability(LIBUSB_CAP_HAS_HOTPLUG) != 0) {
      libusb_hotplug_register_callback(context_.get(), LIBUSB_HOTPLUG_EVENT_DEVICE_LEFT, 0, LIBUSB_HOTPLUG_MATCH_ANY,
                                       LIBUSB_HOTPLUG_MATCH_ANY, LIBUSB_HOTPLUG_MATCH_ANY, &LibusbPort::OnLeft, this,
                                       nullptr);
    }
    for (int number : {channels_.control_interface, channels_.stream_interface}) {
      if (number < 0) continue;
      if (const int error = libusb_claim_interface(handle_.get(), number); error != 0) {
        FailOpen(thing, "claiming interface " + std::to_string(number) + ": " + libusb_strerror(error),
                 error == LIBUSB_ERROR_BUSY ? "Another program uses it: end that" : "Plug it in again");
      }
    }
  }

  ~LibusbPort() override {
    CancelReads();
    if (channels_.has_stream()) libusb_release_interface(handle_.get(), channels_.stream_interface);
    libusb_release_interface(handle_.get(), channels_.control_interface);
  }

  std::string model() const override { return model_; }
  std::string identity() const override { return identity_; }

  Result ControlOut(std::span<const std::uint8_t> data, std::chrono::milliseconds timeout) override {
    return Bulk(channels_.control_out, const_cast<std::uint8_t*>(data.data()), data.size(), timeout);
  }
  Result ControlIn(std::span<std::uint8_t> buffer, std::chrono::milliseconds timeout) override {
    return Bulk(channels_.control_in, buffer.data(), buffer.size(), timeout);
  }
  Status ClearControlHalt() override {
    const int out = libusb_clear_halt(handle_.get(), channels_.control_out);
    const int in = libusb_clear_halt(handle_.get(), channels_.control_in);
    return StatusOf(out != 0 ? out : in);
  }

  bool Present() override {
    timeval none{};
    libusb_handle_events_timeout_completed(context_.get(), &none, nullptr);
    const bool lost = !reads_.empty() && reads_.front()->ended != 0 &&
                      reads_.front()->transfer->status == LIBUSB_TRANSFER_NO_DEVICE;
    return !left_ && !lost;
  }

  Status PostRead(std::span<std::uint8_t> buffer) override {
    auto read = std::make_unique<PostedRead>();
    read->transfer.reset(libusb_alloc_transfer(0));
    if (!read->transfer) return Status::kFailed;
    libusb_fill_bulk_transfer(read->transfer.get(), handle_.get(), channels_.stream_in, buffer.data(),
                              static_cast<int>(buffer.size()), &LibusbPort::OnEnd, read.get(), 0);
    if (const int error = libusb_submit_transfer(read->transfer.get()); error != 0) return StatusOf(error);
    reads_.push_back(std::move(read));
    return Status::kOk;
  }

  std::optional<Result> Reap(std::chrono::milliseconds timeout) override {
    if (reads_.empty()) return std::nullopt;
    const Clock::time_point deadline = Clock::now() + timeout;
    PostedRead& first = *reads_.front();
    while (first.ended == 0) {
      const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline - Clock::now());
      timeval time = TimeOf(std::max(left, std::chrono::milliseconds(0)));
      libusb_handle_events_timeout_completed(context_.get(), &time, &first.ended);
      if (first.ended == 0 && Clock::now() >= deadline) return std::nullopt;
    }
    const Result result{StatusOf(first.transfer->status), static_cast<std::size_t>(first.transfer->actual_length)};
    reads_.pop_front();
    return result;
  }

  // A transfer belongs to libusb until its callback has run, also when the device is gone.
  void CancelReads() noexcept override {
    for (const auto& read : reads_) {
      if (read->ended == 0) libusb_cancel_transfer(read->transfer.get());
    }
    while (!reads_.empty()) {
      PostedRead& last = *reads_.back();
      while (last.ended == 0) {
        timeval time = TimeOf(std::chrono::milliseconds(100));
        libusb_handle_events_timeout_completed(context_.get(), &time, &last.ended);
      }
      reads_.pop_back();
    }
  }

  Status ResetStream() override {
    // Some host controllers do not take a halt that software sets; the clearing is what counts.
    const int halt = libusb_control_transfer(
        handle_.get(), kToEndpoint,
        LIBUSB_REQUEST_SET_FEATURE, kEndpointHalt, channels_.stream_in, nullptr, 0, kRequestTimeout);
    if (halt == LIBUSB_ERROR_NO_DEVICE) return Status::kGone;
    return StatusOf(libusb_clear_halt(handle_.get(), channels_.stream_in));
  }

  Status ResetDevice() override { return StatusOf(libusb_reset_device(handle_.get())); }

 private:
  struct PostedRead {
    std::unique_ptr<libusb_transfer, FreeTransfer> transfer;
    int ended = 0;
  };

  static void LIBUSB_CALL OnEnd(libusb_transfer* transfer) {
    static_cast<PostedRead*>(transfer->user_data)->ended = 1;
  }

  // libusb tells of each device that leaves; it must not be called from here.
  static int LIBUSB_CALL OnLeft(libusb_context*, libusb_device* device, libusb_hotplug_event, void* port) {
    LibusbPort& self = *static_cast<LibusbPort*>(port);
    self.left_ = self.left_ || device == libusb_get_device(self.handle_.get());
    return 0;
  }

  Result Bulk(std::uint8_t endpoint, std::uint8_t* data, std::size_t size, std::chrono::milliseconds timeout) {
    int moved = 0;
    // Zero would mean to wait for ever.
    const auto wait = static_cast<unsigned>(std::max<std::int64_t>(timeout.count(), 1));
    const int error = libusb_bulk_transfer(handle_.get(), endpoint, data, static_cast<int>(size), &moved, wait);
    return {StatusOf(error), static_cast<std::size_t>(moved)};
  }

  Context context_;
  Handle handle_;
  const Channels channels_;
  const std::string model_, identity_;
  std::deque<std::unique_ptr<PostedRead>> reads_;  // oldest first
  bool left_ = false;
};

// `thing` is "camera" or "scanner": what is looked for, by `channels_of`.
std::unique_ptr<UsbPort> Open(const std::string& thing, Channels (*channels_of)(libusb_device*), const std::string& wanted) {
  libusb_context* raw = nullptr;
  if (const int error = libusb_init(&raw); error != 0)
    FailOpen(thing, libusb_strerror(error), "Check that /dev/bus/usb is there");
  Context context(raw);
  libusb_device** list = nullptr;
  const ssize_t count = libusb_get_device_list(context.get(), &list);
  if (count < 0) FailOpen(thing, libusb_strerror(static_cast<int>(count)), "Check that /dev/bus/usb is there");
  struct FreeList { void operator()(libusb_device** devices) const { libusb_free_device_list(devices, 1); } };
  const std::unique_ptr<libusb_device*, FreeList> devices(list);
  struct Found {
    Handle handle;
    Channels channels;
    std::string model, identity;
  };
  std::vector<Found> found;
  std::string seen, denied;
  for (ssize_t i = 0; i < count; ++i) {
    const Channels channels = channels_of(list[i]);
    if (!channels.has_control()) continue;
    libusb_device_handle* opened = nullptr;
    if (const int error = libusb_open(list[i], &opened); error != 0) {
      denied += (denied.empty() ? "" : ", ") + ("bus " + std::to_string(libusb_get_bus_number(list[i]))) + " device " +
                std::to_string(libusb_get_device_address(list[i])) + ": " + libusb_strerror(error);
      continue;
    }
    Handle handle(opened);
    const std::string guid = TextOf(opened, channels.guid_text), serial = TextOf(opened, channels.serial_text);
    const std::string identity = guid.empty() ? serial : guid;
    seen += (seen.empty() ? "" : ", ") + identity;
    if (!wanted.empty() && wanted != guid && wanted != serial) continue;
    found.push_back({std::move(handle), channels, TextOf(opened, channels.model_text), identity});
  }
  if (found.size() > 1) FailOpen(thing, "several are there: " + seen, "Name one of them in rangefinder.identity");
  if (found.empty() && !denied.empty()) {
    FailOpen(thing, "it may not be opened (" + denied + ")", "Install geond's udev rule and plug it in again");
  }
  if (found.empty() && wanted.empty())
    FailOpen(thing, "none is there, it is unplugged", "Plug it in and reset the station");
  if (found.empty()) {
    FailOpen(thing, wanted + " is not there, it is unplugged" + (seen.empty() ? "" : "; there is " + seen),
             "Plug it in and reset the station, or correct rangefinder.identity");
  }
  Found& device = found.front();
  return std::make_unique<LibusbPort>(thing, std::move(context), std::move(device.handle), device.channels, device.model,
                                      device.identity);
}

}  // namespace

UsbOpener LibusbCamera(std::string identity) {
  return [identity = std::move(identity)] { return Open("camera", &CameraChannels, identity); };
}

UsbOpener LibusbScanner(std::string serial) {
  return [serial = std::move(serial)] { return Open("scanner", &ScannerChannels, serial); };
}

}  // namespace geond::drivers
