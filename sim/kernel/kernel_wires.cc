// SPDX-License-Identifier: Apache-2.0
#include "sim/kernel/kernel_wires.h"

#include <fcntl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <iostream>
#include <optional>
#include <sstream>
#include <utility>

#include "core/base/error.h"

namespace geond::sim {
namespace fs = std::filesystem;
namespace {

const fs::path kHostController = "/sys/devices/platform/vhci_hcd.0";
const fs::path kChips = "/sys/kernel/config/gpio-sim";
const fs::path kChip = kChips / "geond";
constexpr std::array kOutputs = {kLaserLine, kMotorLine, kLampLine, kTriggerLine};
constexpr std::array kInputs = {kStopLine, kDoorLine};
constexpr std::chrono::milliseconds kTick(2);
constexpr int kSuperSpeed = 5;
constexpr int kSocketBytes = 4 << 20;

// In one write, as these files want it.
void Write(const fs::path& file, const std::string& text) {
  const int fd = open(file.c_str(), O_WRONLY | O_CLOEXEC);
  const bool written = fd >= 0 && write(fd, text.data(), text.size()) == static_cast<ssize_t>(text.size());
  const int error = errno;
  if (fd >= 0) close(fd);
  if (!written) throw FileError(file.string(), "write", std::strerror(error));
}

std::string Read(const fs::path& file) {
  std::ifstream stream(file);
  std::string word;
  if (!(stream >> word)) throw FileError(file.string(), "read", "nothing there");
  return word;
}

// One of the kernel's files that is read over and over.
class File {
 public:
  File() = default;
  explicit File(const fs::path& path) : path_(path), fd_(open(path.c_str(), O_RDONLY | O_CLOEXEC)) {}
  File(File&& other) noexcept : path_(std::move(other.path_)), fd_(std::exchange(other.fd_, -1)) {}
  File& operator=(File&& other) noexcept {
    std::swap(path_, other.path_);
    std::swap(fd_, other.fd_);
    return *this;
  }
  ~File() {
    if (fd_ >= 0) close(fd_);
  }
  // Its first character now. Throws FileError.
  char First() const {
    char first = 0;
    if (pread(fd_, &first, 1, 0) != 1) throw FileError(path_.string(), "read", std::strerror(errno));
    return first;
  }

 private:
  fs::path path_;
  int fd_ = -1;
};

// A port of the controller's SuperSpeed hub that nothing is plugged into.
int FreePort() {
  std::ifstream status(kHostController / "status");
  if (!status) {
    throw FileError(kHostController.string(), "plug in the camera", "there is no such host controller",
                    "modprobe vhci_hcd");
  }
  constexpr int kFree = 4;
  for (std::string line; std::getline(status, line);) {
    std::istringstream words(line);
    std::string hub;
    int port = 0, state = 0;
    if (words >> hub >> port >> state && hub == "ss" && state == kFree) return port;
  }
  throw FileError(kHostController.string(), "plug in the camera", "no port is free");
}

fs::path LineFile(const fs::path& levels, unsigned line, const char* name) {
  return levels / ("sim_gpio" + std::to_string(line)) / name;
}

}  // namespace

KernelWires::KernelWires(FakeBench& bench, const fs::path& folder) : bench_(bench), folder_(folder) {
  fs::remove(serial_device());
  fs::create_symlink(bench.drive().serial_device(), serial_device());
  try {
    MakeChip();
    Plug();
  } catch (...) {
    RemoveChip();
    throw;
  }
  bench_.OnPlug([this](bool in) {
    if (in) return Plug();
    bench_.camera()->SetPlugged(false);
    camera_.reset();
  });
  carrier_ = std::jthread([this](std::stop_token stop) { Carry(stop); });
}

KernelWires::~KernelWires() {
  bench_.OnPlug([camera = bench_.camera()](bool in) { camera->SetPlugged(in); });
  carrier_ = {};
  camera_.reset();
  RemoveChip();
}

void KernelWires::Plug() {
  int ends[2];
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0) {
    throw FileError("camera", "plug in", std::strerror(errno));
  }
  for (const int end : ends) {
    setsockopt(end, SOL_SOCKET, SO_SNDBUF, &kSocketBytes, sizeof kSocketBytes);
    setsockopt(end, SOL_SOCKET, SO_RCVBUF, &kSocketBytes, sizeof kSocketBytes);
  }
  bench_.camera()->SetPlugged(true);
  camera_ = std::make_unique<UsbipConnection>(*bench_.camera(), ends[0]);
  constexpr int kDevice = 0x10002;  // any bus and number: the kernel gives its own
  try {
    Write(kHostController / "attach", std::to_string(FreePort()) + " " + std::to_string(ends[1]) + " " +
                                          std::to_string(kDevice) + " " + std::to_string(kSuperSpeed));
  } catch (...) {
    close(ends[1]);
    throw;
  }
  close(ends[1]);  // the kernel has its own hold of it
}

void KernelWires::MakeChip() {
  if (!fs::exists(kChips)) {
    throw FileError(kChips.string(), "make a GPIO chip", "there is no such folder",
                    "modprobe gpio-sim, and mount configfs at /sys/kernel/config");
  }
  RemoveChip();  // what a bench that was killed has left
  const fs::path bank = kChip / "bank0";
  fs::create_directories(bank);
  Write(bank / "num_lines", std::to_string(kBenchLines));
  Write(bank / "label", "fake-bench");
  for (unsigned line = 0; line < kBenchLines; ++line) {
    const fs::path folder = bank / ("line" + std::to_string(line));
    fs::create_directory(folder);
    Write(folder / "name", kBenchLineNames[line]);
  }
  Write(kChip / "live", "1");
  chip_name_ = Read(bank / "chip_name");
  levels_ = fs::path("/sys/devices/platform") / Read(kChip / "dev_name") / chip_name_;
}

void KernelWires::RemoveChip() {
  if (!fs::exists(kChip)) return;
  // These folders are not files to be removed one by one: each goes as a whole, the innermost first.
  try {
    Write(kChip / "live", "0");
  } catch (const FileError&) {
  }
  std::error_code ignored;
  for (unsigned line = 0; line < kBenchLines; ++line) rmdir((kChip / "bank0" / ("line" + std::to_string(line))).c_str());
  rmdir((kChip / "bank0").c_str());
  rmdir(kChip.c_str());
}

void KernelWires::Carry(std::stop_token stop) try {
  std::array<File, kOutputs.size()> values;
  std::ranges::transform(kOutputs, values.begin(), [this](BenchLine line) { return File(LineFile(levels_, line, "value")); });
  std::array<std::optional<bool>, kBenchLines> shown;
  while (!stop.stop_requested()) {
    for (std::size_t i = 0; i < kOutputs.size(); ++i) bench_.chip().SetInput(kOutputs[i], values[i].First() == '1');
    for (const BenchLine line : kInputs) {
      const bool high = bench_.chip().level(line);
      if (shown[line] == high) continue;
      Write(LineFile(levels_, line, "pull"), high ? "pull-up" : "pull-down");
      shown[line] = high;
    }
    std::this_thread::sleep_for(kTick);
  }
} catch (const FileError& error) {  // somebody took the chip away
  std::cerr << error.what() << std::endl;
}

}  // namespace geond::sim
