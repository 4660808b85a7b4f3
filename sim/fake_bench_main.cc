// SPDX-License-Identifier: Apache-2.0
// fake_bench [--kernel] SIM.toml FOLDER PROGRAM [ARGUMENT...]: runs a program that finds a whole bench of fake devices:
// a range camera on a USB port, a GPIO chip at /dev/gpiochip90, a drive on the serial port FOLDER/drive. Object, noise,
// seed and faults from the start are those of SIM.toml, as for the simulated station. With --kernel (as root, modules
// vhci_hcd and gpio-sim loaded) camera and chip are the kernel's, for every program there is, and the chip has the next
// free name. Lines read from the pipe FOLDER/orders are orders: fault DEVICE WORD, stop on|off, door open|closed.
#include <sys/stat.h>

#include <cstdlib>
#include <fstream>
#include <iostream>
#include <optional>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "sim/kernel/kernel_wires.h"
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

int Run(std::vector<std::string> arguments) {
  const bool kernel = arguments[0] == "--kernel";
  if (kernel) arguments.erase(arguments.begin());
  const SimConfig config = ReadSimConfig(arguments.at(0));
  const std::filesystem::path folder = arguments.at(1);
  const std::vector<std::string> program(arguments.begin() + 2, arguments.end());
  std::filesystem::create_directories(folder);
  FakeBench bench(OpenSimStation(config));
  std::optional<KernelWires> machine;
  std::optional<FakeWires> wires;
  if (kernel) {
    machine.emplace(bench, folder);
    std::cout << "fake_bench: lines at /dev/" << machine->chip_name() << ", drive at "
              << machine->serial_device().string() << std::endl;
  } else {
    wires.emplace(bench, folder);
  }
  for (const auto& [device, fault] : config.faults) bench.SetFault(device, fault);
  const std::string pipe = folder / "orders";
  mkfifo(pipe.c_str(), 0600);
  std::thread([&bench, pipe] {
    std::fstream orders(pipe);  // for reading and writing, so that it never ends
    for (std::string line; std::getline(orders, line);) {
      try {
        Obey(line, bench);
      } catch (const std::exception& error) {  // no such order, or the kernel would not take the plug
        std::cerr << "fake_bench: " << line << ": " << error.what() << std::endl;
      }
    }
  }).detach();
  return WaitFor(wires ? wires->Start(program) : StartBelow(program, "", {}, {}));
}

}  // namespace
}  // namespace geond::sim

int main(int count, char** arguments) {
  const std::vector<std::string> all(arguments + 1, arguments + count);
  if (all.size() < (!all.empty() && all[0] == "--kernel" ? 4u : 3u)) {
    std::cerr << "usage: fake_bench [--kernel] SIM.toml FOLDER PROGRAM [ARGUMENT...]\n";
    return 2;
  }
  try {
    std::_Exit(geond::sim::Run(all));  // not waiting for the thread that reads orders
  } catch (const std::exception& error) {
    std::cerr << "fake_bench: " << error.what() << "\n";
    return 1;
  }
}
