// SPDX-License-Identifier: Apache-2.0
// fake_bench SIM.toml FOLDER PROGRAM [ARGUMENT...]: runs a program that finds a whole bench of fake devices: a range
// camera on a USB port, a GPIO chip at /dev/gpiochip90, a drive on the serial port FOLDER/drive. Object, noise, seed
// and faults from the start are those of SIM.toml, as for the simulated station. Lines read from the pipe FOLDER/orders
// are orders: fault DEVICE WORD, stop on|off, door open|closed.
#include <sys/stat.h>

#include <cstdlib>
#include <fstream>
#include <iostream>
#include <sstream>
#include <string>
#include <thread>

#include "sim/sim_config.h"
#include "sim/usb/fake_wires.h"

namespace geond::sim {
namespace {

void Obey(const std::string& line, FakeBench& bench) {
  std::istringstream words(line);
  std::string order, first, second;
  words >> order >> first >> second;
  if (order == "fault") return bench.SetFault(DeviceFromName(first), FaultFromName(second));
  if (order == "stop") return bench.SetEmergencyStop(first == "on");
  if (order == "door") return bench.SetDoorOpen(first == "open");
  throw std::invalid_argument("no such order");
}

int Run(char** arguments, int count) {
  const SimConfig config = ReadSimConfig(arguments[1]);
  const std::filesystem::path folder = arguments[2];
  std::filesystem::create_directories(folder);
  FakeBench bench(OpenSimStation(config));
  FakeWires wires(bench, folder);
  for (const auto& [device, fault] : config.faults) bench.SetFault(device, fault);
  const std::string pipe = folder / "orders";
  mkfifo(pipe.c_str(), 0600);
  std::thread([&bench, pipe] {
    std::fstream orders(pipe);  // for reading and writing, so that it never ends
    for (std::string line; std::getline(orders, line);) {
      try {
        Obey(line, bench);
      } catch (const std::invalid_argument& error) {
        std::cerr << "fake_bench: " << line << ": " << error.what() << std::endl;
      }
    }
  }).detach();
  return WaitFor(wires.Start({arguments + 3, arguments + count}));
}

}  // namespace
}  // namespace geond::sim

int main(int count, char** arguments) {
  if (count < 4) {
    std::cerr << "usage: fake_bench SIM.toml FOLDER PROGRAM [ARGUMENT...]\n";
    return 2;
  }
  try {
    std::_Exit(geond::sim::Run(arguments, count));  // not waiting for the thread that reads orders
  } catch (const std::exception& error) {
    std::cerr << "fake_bench: " << error.what() << "\n";
    return 1;
  }
}
