// SPDX-License-Identifier: Apache-2.0
// Every fault of every device, at the wire, in the middle of a scan by the real service on the real drivers: which
// error it ends in and when, when the laser is off and the table stands, and whether the next scan succeeds after a
// reset. Prints a table; exits 1 if a cell falls short. Arguments: words, of which one must be in the name of a cell
// for it to be run.
#include <signal.h>
#include <unistd.h>

#include <cstdio>
#include <functional>
#include <string>
#include <tuple>
#include <vector>

#include "tests/support/fault_run.h"

namespace geond {
namespace {

using sim::Device;
using sim::Fault;
using sim::WireFault;
using Clock = std::chrono::steady_clock;

constexpr double kLongestToError = 2000, kLongestToOff = 100;  // ms
constexpr unsigned kHang = 60;                                 // s: a cell that takes longer never ends

struct Cell {
  std::string name;
  std::function<void(HardwareRig&)> inject, mend;
  std::string words;          // the error names this; "mended": there must be no error
  bool off_by_event = false;  // laser and motion must be off within the limit of the event itself, not of the error
};

std::vector<Cell> Words() {
  // What each word must make the error say.
  const std::vector<std::pair<Fault, std::vector<std::string>>> words = {
      {Fault::kOff, {"unplugged", "no reply", "wires cannot be read"}},
      {Fault::kStuck, {"no image within", "does not turn", "could not be switched off|done"}},
      {Fault::kGarbage, {"magic number", "turntable", "emergency stop"}},
      {Fault::kWrong, {"pixels where", "turntable", "emergency stop"}},
      {Fault::kSlow, {"done", "not in position", "took"}},
      {Fault::kDelayed, {"no image within", "turntable", "done"}},
      {Fault::kIntermittent, {"no image within", "turntable", "Input/output error"}},
  };
  std::vector<Cell> cells;
  for (const Device device : sim::kDevices) {
    for (const auto& [fault, said] : words) {
      cells.push_back({std::string(sim::DeviceName(device)) + " " + std::string(sim::FaultName(fault)),
                       [device, fault](HardwareRig& rig) { rig.bench().SetFault(device, fault); },
                       [device](HardwareRig& rig) { rig.bench().SetFault(device, Fault::kNone); },
                       said[static_cast<std::size_t>(device)], fault == Fault::kOff});
    }
  }
  return cells;
}

Cell CameraCell(const std::string& name, int sim::FakeCameraFaults::*fault, int times, const std::string& words) {
  return {"camera: " + name,
          [fault, times](HardwareRig& rig) {
            sim::FakeCameraFaults faults;
            faults.*fault = times;
            rig.bench().camera()->SetFaults(faults);
          },
          [](HardwareRig& rig) { rig.bench().camera()->SetFaults({}); }, words, false};
}

Cell DriveCell(const std::string& name, WireFault fault, int exception, const std::string& words) {
  return {"drive: " + name,
          [fault, exception](HardwareRig& rig) {
            if (exception != 0) rig.bench().drive().SetException(exception);
            rig.bench().drive().SetFault(fault);
          },
          [](HardwareRig& rig) { rig.bench().drive().SetFault(WireFault::kNone); }, words, false};
}

std::vector<Cell> Items() {
  using Faults = sim::FakeCameraFaults;
  const auto nothing = [](HardwareRig&) {};
  // "mended": each costs a repeat and no more.
  const std::tuple<const char*, int Faults::*, int, const char*> camera_faults[] = {
      {"acknowledge lost", &Faults::lost_acknowledges, 2, "mended"},
      {"acknowledge of another command", &Faults::stale_acknowledges, 2, "mended"},
      {"acknowledge without magic", &Faults::broken_acknowledges, 2, "mended"},
      {"acknowledge cut short", &Faults::short_acknowledges, 2, "mended"},
      {"still working", &Faults::pending_acknowledges, 2, "mended"},
      {"busy", &Faults::busy_answers, 2, "mended"},
      {"control stall", &Faults::control_stalls, 1, "mended"},
      {"stream stall", &Faults::stream_stalls, 1, "mended"},
      {"stream stalls for good", &Faults::stream_stalls, 1000, "stalled"},
      {"leader without magic", &Faults::bad_leaders, 1, "magic"},
      {"short frame", &Faults::short_payloads, 1, "bytes"},
      {"overrun trailer", &Faults::overrun_trailers, 1, "overrun"},
      {"trailer of another block", &Faults::wrong_blocks, 1, "block"},
  };
  std::vector<Cell> cells;
  for (const auto& [name, fault, times, words] : camera_faults) cells.push_back(CameraCell(name, fault, times, words));
  cells.push_back({"camera: unplugged in mid-transfer",
                   [](HardwareRig& rig) {
                     sim::FakeCameraFaults faults;
                     faults.frame_delay = std::chrono::milliseconds(800);
                     rig.bench().camera()->SetFaults(faults);
                     while (rig.bench().table_turns()) usleep(500);
                     usleep(100'000);  // an image is on its way
                     rig.bench().SetFault(Device::kRangefinder, Fault::kOff);
                   },
                   [](HardwareRig& rig) { rig.bench().SetFault(Device::kRangefinder, Fault::kNone); }, "unplugged",
                   false});
  for (const int code : {1, 2, 3, 4, 5, 6, 11}) {
    cells.push_back(DriveCell("exception " + std::to_string(code), WireFault::kWrong, code, "turntable"));
  }
  cells.push_back(DriveCell("late replies", WireFault::kDelayed, 0, "no reply"));
  cells.push_back(DriveCell("wrong unit", WireFault::kWrongUnit, 0, "turntable"));
  cells.push_back(DriveCell("wrong checksum", WireFault::kBadChecksum, 0, "turntable"));
  cells.push_back(DriveCell("half frames", WireFault::kHalfFrame, 0, "turntable"));
  cells.push_back(
      {"drive: alarm", [](HardwareRig& rig) { rig.bench().drive().RaiseAlarm(0x30); }, nothing, "overload", true});
  cells.push_back({"law: emergency stop", [](HardwareRig& rig) { rig.bench().SetEmergencyStop(true); },
                   [](HardwareRig& rig) { rig.bench().SetEmergencyStop(false); }, "emergency stop is pressed", true});
  cells.push_back({"law: door opened", [](HardwareRig& rig) { rig.bench().SetDoorOpen(true); },
                   [](HardwareRig& rig) { rig.bench().SetDoorOpen(false); }, "door is open", true});
  cells.push_back({"law: emergency stop for an instant",
                   [](HardwareRig& rig) {
                     rig.bench().SetEmergencyStop(true);
                     usleep(3000);
                     rig.bench().SetEmergencyStop(false);
                   },
                   nothing, "emergency stop is pressed", true});
  return cells;
}

// "a|b": one of them.
bool Says(const std::string& error, const std::string& words) {
  for (std::size_t at = 0; at <= words.size();) {
    const std::size_t bar = std::min(words.find('|', at), words.size());
    const std::string one = words.substr(at, bar - at);
    if ((one == "done" || one == "mended") ? error.empty() : error.find(one) != std::string::npos) return true;
    at = bar + 1;
  }
  return false;
}

// What happens to laser and motion when the service itself dies, hangs, or is told off afterwards.
bool Deaths() {
  bool good = true;
  const auto report = [&](const char* name, const FaultOutcome& row, double most_standing, const std::string& rest) {
    const bool fine = row.to_dark <= kLongestToOff && row.to_standing <= most_standing && rest.empty();
    std::printf("%-42s %8s %8.0f %8.0f   %s%s\n", name, "-", row.to_dark, row.to_standing, rest.c_str(),
                fine ? "" : "  FALLS SHORT");
    good = good && fine;
  };
  const auto in_motion = [](HardwareRig& rig) {
    rig.Start();
    StartInMotion(rig);
    return Clock::now();
  };
  const HardwareRig::Options slow{.table_speed = 20};
  {
    HardwareRig rig(slow);
    const Clock::time_point begin = in_motion(rig);
    rig.Kill();
    FaultOutcome row;
    MeasureOff(rig.bench(), begin, row);
    report("law: service killed with -9", row, kLongestToOff,
           rig.bench().camera()->acquiring() ? "" : "camera stopped by itself?");
    const int status = rig.Run({"--safe-off"});
    const bool off = status == 0 && !rig.bench().camera()->acquiring() && !rig.bench().drive().enabled();
    std::printf("%-42s %8s %8s %8s   %s\n", "law: --safe-off after that", "-", "-", "-",
                off ? "camera and drive off" : "FALLS SHORT");
    good = good && off;
  }
  {
    HardwareRig rig(slow);
    rig.bench().BridgeMotorContact(true);
    const Clock::time_point begin = in_motion(rig);
    rig.Kill();
    FaultOutcome row;
    MeasureOff(rig.bench(), begin, row);
    report("law: killed, motor's contactor welded", row, 600, "");  // the drive's own timeout is 500 ms
  }
  {
    HardwareRig rig(slow);
    const Clock::time_point begin = in_motion(rig);
    rig.Signal(SIGSTOP);  // hangs: what the service manager's watchdog is for
    FaultOutcome hung;
    MeasureOff(rig.bench(), begin, hung);
    const Clock::time_point bitten = Clock::now();
    rig.Kill();
    FaultOutcome row;
    MeasureOff(rig.bench(), bitten, row);
    row.to_standing = hung.to_standing;
    report("law: hangs, then the watchdog bites", row, 600, "");
  }
  return good;
}

int Main(int count, char** arguments) {
  std::vector<Cell> cells = Words();
  for (Cell& cell : Items()) cells.push_back(std::move(cell));
  const auto wanted = [&](const std::string& name) {
    for (int i = 1; i < count; ++i) {
      if (name.find(arguments[i]) != std::string::npos) return true;
    }
    return count < 2;
  };
  std::printf(
      "Times in ms from the fault. Error within %.0f; laser off and table standing within %.0f of the error, where * "
      "of the fault.\n\n",
      kLongestToError, kLongestToOff);
  std::printf("%-42s %8s %8s %8s   %-9s %s\n", "fault", "error", "dark", "stands", "next scan", "error");
  bool good = true;
  int descriptors = 0;
  {
    HardwareRig rig({});
    rig.Start();
    for (const Cell& cell : cells) {
      if (!wanted(cell.name)) continue;
      alarm(kHang);
      const FaultOutcome row = RunFault(
          rig, [&] { cell.inject(rig); }, [&] { cell.mend(rig); });
      if (descriptors == 0) descriptors = rig.OpenDescriptors();
      const double limit = cell.off_by_event ? kLongestToOff : row.to_error + kLongestToOff;
      const bool mended = row.error.empty();
      const bool fine = Says(row.error, cell.words) && (mended || row.to_error <= kLongestToError) &&
                        (mended || (row.to_dark <= limit && row.to_standing <= limit)) && row.next_scan;
      std::printf("%-41s%s %8.0f %8.0f %8.0f   %-9s %s%s\n", cell.name.c_str(), cell.off_by_event ? "*" : " ",
                  row.to_error, row.to_dark, row.to_standing, row.next_scan ? "done" : "FAILED",
                  mended ? "(none: the scan was done)" : row.error.c_str(), fine ? "" : "  FALLS SHORT");
      std::fflush(stdout);
      good = good && fine;
    }
    const int more = rig.OpenDescriptors() - descriptors;
    std::printf("\nDescriptors of the service: %d more after all of these than after the first.\n", more);
    good = good && more <= 0;
  }
  alarm(kHang);
  if (wanted("law: killed hangs --safe-off")) good = Deaths() && good;
  return good ? 0 : 1;
}

}  // namespace
}  // namespace geond

int main(int count, char** arguments) { return geond::Main(count, arguments); }
