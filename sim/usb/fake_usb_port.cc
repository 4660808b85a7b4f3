// SPDX-License-Identifier: Apache-2.0
#include "sim/usb/fake_usb_port.h"

#include <fcntl.h>
#include <linux/usbdevice_fs.h>
#include <pty.h>
#include <sys/wait.h>
#include <termios.h>
#include <umockdev.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <list>
#include <mutex>
#include <set>
#include <thread>

#include "core/base/error.h"
#include "sim/fake_usb_device.h"

namespace geond::sim {
namespace {

// The kernel's side of a USB device file: takes, completes and hands back the requests of programs, each those of its own
// open file. One lock for all; umockdev calls from its own thread, orders come from another.
class UsbDeviceFile {
 public:
  UsbDeviceFile(FakeCamera& camera, UMockdevTestbed* testbed) : camera_(camera), testbed_(testbed) {
    handler_ = umockdev_ioctl_base_new();
    g_signal_connect(handler_, "handle-ioctl", G_CALLBACK(&UsbDeviceFile::OnIoctl), this);
    g_signal_connect(handler_, "client-vanished", G_CALLBACK(&UsbDeviceFile::OnVanished), this);
  }

  void Plug() {
    const std::lock_guard lock(mutex_);
    gone_ = false;
    camera_.SetPlugged(true);
    umockdev_testbed_attach_ioctl(testbed_, Node().c_str(), handler_, nullptr);
    const std::string number = std::to_string(number_);
    std::string text = "P: " + Path() + "\nN: bus/usb/001/00" + number +
                       "\nE: SUBSYSTEM=usb\nE: DRIVER=usb\nE: BUSNUM=001\nE: DEVNUM=00" + number +
                       "\nE: DEVNAME=" + Node() +
                       "\nE: DEVTYPE=usb_device\nE: MAJOR=189\nE: MINOR=" + std::to_string(number_ - 1) +
                       "\nA: bConfigurationValue=1\\n\nA: busnum=1\\n\nA: devnum=" + number +
                       "\\n\nA: speed=5000\\n\nA: dev=189:" + std::to_string(number_ - 1) + "\\n\nH: descriptors=";
    for (std::uint8_t byte : FakeUsbDescriptors()) {
      char hex[3];
      std::snprintf(hex, sizeof hex, "%02X", byte);
      text += hex;
    }
    // A terminal whose output is stopped and started stands in for the device file: programs wait for it to be
    // writable, as usbfs is when a request is done, and see it hang up when the device is gone.
    char name[128];
    if (openpty(&master_, &slave_, name, nullptr, nullptr) != 0) std::perror("openpty");
    termios settings{};
    tcgetattr(slave_, &settings);
    cfmakeraw(&settings);
    tcsetattr(slave_, TCSANOW, &settings);
    ready_ = true;
    SetReady(false);
    GError* error = nullptr;
    if (!umockdev_testbed_add_from_string(testbed_, (text + "\n").c_str(), &error)) std::cerr << error->message << "\n";
    const std::string file = Root() + Node();
    unlink(file.c_str());
    if (symlink(name, file.c_str()) != 0) std::perror("symlink");
  }

  void Unplug() {
    {
      const std::lock_guard lock(mutex_);
      gone_ = true;
      camera_.SetPlugged(false);
      for (Request& request : waiting_) request.status = -ESHUTDOWN;
      done_.splice(done_.end(), waiting_);
      SetReady(true);
      close(master_);
      close(slave_);
      master_ = slave_ = -1;
    }
    umockdev_testbed_uevent(testbed_, ("/sys" + Path()).c_str(), "remove");
    umockdev_testbed_remove_device(testbed_, ("/sys" + Path()).c_str());
    umockdev_testbed_detach_ioctl(testbed_, Node().c_str(), nullptr);
    ++number_;
  }

  // Completes what can be completed now.
  void Kick() {
    const std::lock_guard lock(mutex_);
    std::set<std::uint8_t> blocked;  // transfers of one endpoint end in their order
    for (auto request = waiting_.begin(); request != waiting_.end();) {
      const auto here = request++;
      const std::uint8_t endpoint = Urb(*here).endpoint;
      if (blocked.contains(endpoint)) continue;
      if (Complete(*here)) {
        done_.splice(done_.end(), waiting_, here);
      } else {
        blocked.insert(endpoint);
      }
    }
    SetReady(!done_.empty());
  }

 private:
  struct Request {
    UMockdevIoctlClient* client = nullptr;
    UMockdevIoctlData* urb = nullptr;
    UMockdevIoctlData* buffer = nullptr;
    int status = 0, size = 0;
  };

  static usbdevfs_urb& Urb(const Request& request) { return *reinterpret_cast<usbdevfs_urb*>(request.urb->data); }
  std::string Node() const { return "/dev/bus/usb/001/00" + std::to_string(number_); }
  std::string Path() const { return "/devices/pci0/usb1/1-" + std::to_string(number_); }
  std::string Root() const {
    gchar* root = umockdev_testbed_get_root_dir(testbed_);
    const std::string text = root;
    g_free(root);
    return text;
  }

  void SetReady(bool ready) {
    if (slave_ >= 0 && ready != ready_ && tcflow(slave_, ready ? TCOON : TCOOFF) == 0) ready_ = ready;
  }

  bool Complete(Request& request) {
    usbdevfs_urb& urb = Urb(request);
    int result = 0;
    if (urb.type == USBDEVFS_URB_TYPE_CONTROL) {
      result = FakeUsbControl(camera_, {request.buffer->data, 8},
                              {request.buffer->data + 8, static_cast<std::size_t>(urb.buffer_length - 8)});
    } else if (urb.buffer_length > 0) {
      result = camera_.Transfer(urb.endpoint, {request.buffer->data, static_cast<std::size_t>(urb.buffer_length)});
    }
    if (result == FakeCamera::kNothingYet) return false;
    request.status = std::min(result, 0);
    request.size = std::max(result, 0);
    return true;
  }

  // A program has closed the device file, or died: what it asked for is of no use to the next.
  static void OnVanished(UMockdevIoctlBase*, UMockdevIoctlClient* client, gpointer self) {
    static_cast<UsbDeviceFile*>(self)->Forget(client);
  }

  void Forget(const UMockdevIoctlClient* client) {
    const std::lock_guard lock(mutex_);
    for (std::list<Request>* requests : {&waiting_, &done_}) {
      requests->remove_if([client](const Request& request) {
        if (request.client != client) return false;
        if (request.buffer != nullptr) g_object_unref(request.buffer);
        g_object_unref(request.urb);
        return true;
      });
    }
    SetReady(!done_.empty() || gone_);
  }

  static gboolean OnIoctl(UMockdevIoctlBase*, UMockdevIoctlClient* client, gpointer self) {
    return static_cast<UsbDeviceFile*>(self)->Ioctl(client);
  }

  gboolean Ioctl(UMockdevIoctlClient* client) {
    const std::lock_guard lock(mutex_);
    const gulong request = umockdev_ioctl_client_get_request(client);
    UMockdevIoctlData* argument = umockdev_ioctl_client_get_arg(client);
    const auto answer = [&](long result, int error) {
      umockdev_ioctl_client_complete(client, result, error);
      return TRUE;
    };
    const bool reap = request == USBDEVFS_REAPURB || request == USBDEVFS_REAPURBNDELAY;
    if (gone_ && !reap && request != USBDEVFS_RELEASEINTERFACE) return answer(-1, ENODEV);
    switch (request) {
      case USBDEVFS_GET_CAPABILITIES: {
        UMockdevIoctlData* data = umockdev_ioctl_data_resolve(argument, 0, 4, nullptr);
        *reinterpret_cast<guint32*>(data->data) =
            USBDEVFS_CAP_NO_PACKET_SIZE_LIM | USBDEVFS_CAP_REAP_AFTER_DISCONNECT | USBDEVFS_CAP_ZERO_PACKET;
        g_object_unref(data);
        return answer(0, 0);
      }
      case USBDEVFS_CLAIMINTERFACE:
      case USBDEVFS_RELEASEINTERFACE:
      case USBDEVFS_SETINTERFACE:
      case USBDEVFS_SETCONFIGURATION:
      case USBDEVFS_DISCONNECT_CLAIM:
        return answer(0, 0);
      case USBDEVFS_GETDRIVER:
        return answer(-1, ENODATA);
      case USBDEVFS_RESET:
        camera_.ResetDevice();
        return answer(0, 0);
      case USBDEVFS_CLEAR_HALT:
      case USBDEVFS_RESETEP: {
        UMockdevIoctlData* data = umockdev_ioctl_data_resolve(argument, 0, 4, nullptr);
        camera_.SetHalt(static_cast<std::uint8_t>(*reinterpret_cast<unsigned*>(data->data)), false);
        g_object_unref(data);
        Kick();
        return answer(0, 0);
      }
      case USBDEVFS_SUBMITURB: {
        Request added;
        added.client = client;
        added.urb = umockdev_ioctl_data_resolve(argument, 0, sizeof(usbdevfs_urb), nullptr);
        if (added.urb == nullptr) return answer(-1, EFAULT);
        const auto size = static_cast<gsize>(Urb(added).buffer_length);
        added.buffer = umockdev_ioctl_data_resolve(added.urb, offsetof(usbdevfs_urb, buffer), size, nullptr);
        waiting_.push_back(added);
        Kick();
        return answer(0, 0);
      }
      case USBDEVFS_DISCARDURB: {
        const gulong address = *reinterpret_cast<gulong*>(argument->data);
        for (auto it = waiting_.begin(); it != waiting_.end(); ++it) {
          if (it->client != client || it->urb->client_addr != address) continue;
          it->status = -ENOENT;
          done_.splice(done_.end(), waiting_, it);
          SetReady(true);
          return answer(0, 0);
        }
        return answer(-1, EINVAL);
      }
      case USBDEVFS_REAPURB:
      case USBDEVFS_REAPURBNDELAY:
        return Reap(client, argument);
      default:
        return answer(-1, ENOTTY);
    }
  }

  gboolean Reap(UMockdevIoctlClient* client, UMockdevIoctlData* argument) {
    const auto own = std::ranges::find(done_, client, &Request::client);
    if (own == done_.end()) {
      umockdev_ioctl_client_complete(client, -1, gone_ ? ENODEV : EAGAIN);
      return TRUE;
    }
    const Request request = *own;
    done_.erase(own);
    Urb(request).status = request.status;
    Urb(request).actual_length = request.size;
    UMockdevIoctlData* pointer = umockdev_ioctl_data_resolve(argument, 0, sizeof(void*), nullptr);
    umockdev_ioctl_data_set_ptr(pointer, 0, request.urb);
    SetReady(!done_.empty() || gone_);
    umockdev_ioctl_client_complete(client, 0, 0);
    g_object_unref(pointer);
    if (request.buffer != nullptr) g_object_unref(request.buffer);
    g_object_unref(request.urb);
    return TRUE;
  }

  FakeCamera& camera_;
  UMockdevTestbed* testbed_;
  UMockdevIoctlBase* handler_ = nullptr;
  std::recursive_mutex mutex_;
  std::list<Request> waiting_, done_;
  bool gone_ = false, ready_ = true;
  int number_ = 2, master_ = -1, slave_ = -1;
};

constexpr char kRootHub[] =  // which libusb wants to see above every device
    "P: /devices/pci0/usb1\nN: bus/usb/001/001\nE: SUBSYSTEM=usb\nE: DRIVER=usb\nE: BUSNUM=001\nE: DEVNUM=001\n"
    "E: DEVNAME=/dev/bus/usb/001/001\nE: DEVTYPE=usb_device\nA: bConfigurationValue=1\\n\nA: busnum=1\\n\n"
    "A: devnum=1\\n\nA: speed=5000\\n\n"
    "H: "
    "descriptors="
    "12010003090003096b1d030001060302010109021f0001010ae0000904000001090000000705810304000c063000000200\n";
constexpr std::chrono::milliseconds kTick(2);  // between looks at frames that are due

}  // namespace

struct FakeUsbPort::Parts {
  explicit Parts(FakeCamera& seen) : camera(seen), testbed(umockdev_testbed_new()), file(camera, testbed) {
    gchar* name = umockdev_testbed_get_root_dir(testbed);
    root = name;
    g_free(name);
    umockdev_testbed_add_from_string(testbed, kRootHub, nullptr);
    file.Plug();
    ticker = std::jthread([this](std::stop_token stop) {
      while (!stop.stop_requested()) {
        camera.WaitForChange(kTick);
        file.Kick();
      }
    });
  }
  ~Parts() {
    ticker = {};
    // Not the testbed itself: what it would wait for is gone with the programs that used it.
    std::error_code ignored;
    if (root.starts_with("/tmp/umockdev.")) std::filesystem::remove_all(root, ignored);
  }

  FakeCamera& camera;
  UMockdevTestbed* testbed;
  UsbDeviceFile file;
  std::string root;
  std::jthread ticker;
};

FakeUsbPort::FakeUsbPort(FakeCamera& camera) : parts_(std::make_unique<Parts>(camera)) {}
FakeUsbPort::~FakeUsbPort() = default;
void FakeUsbPort::Plug() { parts_->file.Plug(); }
void FakeUsbPort::Unplug() { parts_->file.Unplug(); }
std::string FakeUsbPort::folder() const { return parts_->root; }

}  // namespace geond::sim
