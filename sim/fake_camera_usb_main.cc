// SPDX-License-Identifier: Apache-2.0
// fake_camera_usb SCENE COLUMNS ROWS CONTROL PROGRAM [ARGUMENT...]: runs a program for which a fake range camera is
// plugged in, looking at a scene. The program needs no change and no kernel support: its system calls are answered by
// umockdev. Lines read from the pipe CONTROL (made if its name is not "-") are orders: plug, unplug, trigger, stall,
// overrun, bad_leader, lose_acknowledge.
#include <sys/stat.h>

#include <cstdlib>
#include <fstream>
#include <iostream>
#include <string>
#include <thread>

#include "sim/range_camera.h"
#include "sim/scene.h"
#include "sim/usb/fake_usb_port.h"
#include "sim/usb/fake_wires.h"

namespace geond::sim {
namespace {

void Obey(const std::string& order, FakeCamera& camera, FakeUsbPort& port) {
  FakeCameraFaults faults = camera.faults();
  if (order == "plug") return port.Plug();
  if (order == "unplug") return port.Unplug();
  if (order == "trigger") return camera.WireTrigger();
  if (order == "stall")
    ++faults.stream_stalls;
  else if (order == "overrun")
    ++faults.overrun_trailers;
  else if (order == "bad_leader")
    ++faults.bad_leaders;
  else if (order == "lose_acknowledge")
    ++faults.lost_acknowledges;
  else
    std::cerr << "fake_camera_usb: unknown order '" << order << "'\n";
  camera.SetFaults(faults);
}

int Run(char** arguments, int count) {
  const StationGeometry station = MakeStation(0.450, 0.489, 0.060, std::atoi(arguments[2]), std::atoi(arguments[3]));
  const Pose X_TS = SensorInTurntable(station, 0.0);
  const SceneGeometry scene(ReadScene(arguments[1]));
  std::uint64_t frame = 0;
  FakeCamera camera(station.sensor, [&]() -> RangeImage {
    return TakeRangeImage(scene, station.sensor, X_TS, CameraOptions{}, 1, frame++, 1);
  });
  FakeUsbPort port(camera);
  const std::string control = arguments[4];
  if (control != "-") {
    mkfifo(control.c_str(), 0600);
    std::thread([&camera, &port, control] {
      std::fstream orders(control);  // for reading and writing, so that it never ends
      for (std::string order; std::getline(orders, order);) Obey(order, camera, port);
    }).detach();
  }
  const int status = WaitFor(
      StartBelow({arguments + 5, arguments + count}, FakeUsbPort::kPreload, {"UMOCKDEV_DIR=" + port.folder()}, {}));
  std::cout.flush();
  return status;
}

}  // namespace
}  // namespace geond::sim

int main(int count, char** arguments) {
  if (count < 6) {
    std::cerr << "usage: fake_camera_usb SCENE COLUMNS ROWS CONTROL|- PROGRAM [ARGUMENT...]\n";
    return 2;
  }
  try {
    std::_Exit(geond::sim::Run(arguments, count));  // not waiting for the thread that reads orders
  } catch (const std::exception& error) {
    std::cerr << "fake_camera_usb: " << error.what() << "\n";
    return 1;
  }
}
