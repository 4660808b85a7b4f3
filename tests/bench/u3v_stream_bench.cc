// SPDX-License-Identifier: Apache-2.0
// Frames a second that come through libusb from a fake camera on a fake USB port, and the processor time they take: our
// driver, which decodes them to depth, against Debian's Aravis (arv-camera-test-0.8), which does not, in turns on the
// same fake. The port is umockdev's, so the figures are its as well; what counts is the ratio. Arguments: seconds (4),
// turns (2).
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "drivers/libusb_port.h"
#include "drivers/u3v_depth.h"
#include "drivers/u3v_rangefinder.h"
#include "sim/usb/fake_wires.h"

namespace geond {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr int kPixels = 1024;

double Seconds(const timeval& time) {
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

// Below the fake port: takes frames for so long and prints how many.
int Inside(double seconds) {
  drivers::U3vRangefinderOptions options;
  options.trigger = drivers::U3vRangefinderOptions::Trigger::kNone;
  drivers::U3vRangefinder camera(drivers::LibusbCamera(""), options);
  camera.Arm();
  const Clock::time_point begin = Clock::now();
  int frames = 0;
  while (std::chrono::duration<double>(Clock::now() - begin).count() < seconds) {
    camera.Read(std::chrono::seconds(10), {});
    ++frames;
  }
  std::printf("frames %d\n", frames);
  return 0;
}

// Processor time of the part that Aravis leaves to its user: from numbers to depths, most in range. Milliseconds a frame.
double DecodingTime() {
  drivers::u3v::Frame frame;
  frame.leader.width = frame.leader.height = frame.trailer.height = kPixels;
  frame.leader.pixel_format = static_cast<std::uint32_t>(drivers::u3v::PixelFormat::kCoord3dC16);
  for (int i = 0; i < kPixels * kPixels; ++i) {
    const int number = 12000 + i / 25 % 4000;
    frame.payload.push_back(static_cast<std::uint8_t>(number & 0xff));
    frame.payload.push_back(static_cast<std::uint8_t>(number >> 8));
  }
  constexpr int kFrames = 200;
  const std::clock_t begin = std::clock();
  for (int k = 0; k < kFrames; ++k) drivers::u3v::DecodeDepth(frame, {2.5e-5, 0.0, 1.0, 0.0}, {0.1, 1.8});
  return 1e3 * static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC / kFrames;
}

struct Client {
  std::string name;
  std::vector<std::string> arguments;
};

void Measure(const Client& client, sim::FakeCamera& camera, const sim::FakeUsbPort& port) {
  const std::uint64_t before = camera.frames();
  rusage start{}, end{};
  getrusage(RUSAGE_CHILDREN, &start);
  const Clock::time_point begin = Clock::now();
  const fs::path log = fs::temp_directory_path() / ("u3v_stream_bench_" + std::to_string(getpid()));
  const int status = sim::WaitFor(
      sim::StartBelow(client.arguments, sim::FakeUsbPort::kPreload, {"UMOCKDEV_DIR=" + port.folder()}, log));
  const double wall = std::chrono::duration<double>(Clock::now() - begin).count();
  getrusage(RUSAGE_CHILDREN, &end);
  const double cpu = Seconds(end.ru_utime) + Seconds(end.ru_stime) - Seconds(start.ru_utime) - Seconds(start.ru_stime);
  const auto frames = static_cast<double>(camera.frames() - before);
  std::printf("%-22s exit %d  %6.0f frames  %6.1f frames/s  %5.2f CPU s  %6.2f CPU ms a frame\n", client.name.c_str(),
              status, frames, frames / wall, cpu, 1e3 * cpu / std::max(1.0, frames));
  fs::remove(log);
}

int Main(const std::string& seconds, int turns) {
  SensorModel sensor;
  sensor.columns = sensor.rows = kPixels;
  sensor.focal_u = sensor.focal_v = 1500.0;
  sensor.min_depth = 0.2;
  sensor.max_depth = 1.2;
  sim::FakeCamera camera(sensor, [] {
    RangeImage image{kPixels, kPixels, {}};
    for (int i = 0; i < kPixels * kPixels; ++i) image.depth.push_back(0.3f + 1e-6f * static_cast<float>(i % 100000));
    return image;
  });
  const sim::FakeUsbPort port(camera);
  const std::vector<Client> clients = {
      {"geond's driver", {fs::read_symlink("/proc/self/exe").string(), "--inside", seconds}},
      {"Aravis, synchronous", {"arv-camera-test-0.8", "--duration=" + seconds, "--usb-mode=sync"}},
      {"Aravis, asynchronous", {"arv-camera-test-0.8", "--duration=" + seconds, "--usb-mode=async"}},
  };
  std::printf("%d x %d Coord3D_C16, %s s each\n", kPixels, kPixels, seconds.c_str());
  for (int turn = 0; turn < turns; ++turn) {
    for (const Client& client : clients) Measure(client, camera, port);
    std::printf("of geond's, decoding timed alone %27.2f CPU ms a frame\n", DecodingTime());
  }
  return 0;
}

}  // namespace
}  // namespace geond

int main(int count, char** arguments) {
  if (count > 2 && std::string(arguments[1]) == "--inside") return geond::Inside(std::atof(arguments[2]));
  return geond::Main(count > 1 ? arguments[1] : "4", count > 2 ? std::atoi(arguments[2]) : 2);
}
