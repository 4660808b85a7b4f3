// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <thread>

#include "sim/fake_bench.h"
#include "sim/kernel/usbip_connection.h"

namespace geond::sim {

// Shows a fake bench to the whole machine by the kernel's own means: its camera as a USB device of vhci_hcd, its lines as
// a chip of gpio-sim, its drive on the serial port folder/drive. Needs those two modules, configfs at
// /sys/kernel/config, and root; everything is gone with it. Faults of the lines that concern the chip itself (off, stuck,
// slow, intermittent) do not reach a kernel's chip.
class KernelWires {
 public:
  // `folder` must exist. Throws FileError, with what is missing.
  KernelWires(FakeBench& bench, const std::filesystem::path& folder);
  ~KernelWires();
  KernelWires(const KernelWires&) = delete;
  KernelWires& operator=(const KernelWires&) = delete;

  std::filesystem::path serial_device() const { return folder_ / "drive"; }
  std::string chip_name() const { return chip_name_; }  // gpiochipN

 private:
  void Plug();
  void MakeChip();
  void RemoveChip();
  void Carry(std::stop_token stop);

  FakeBench& bench_;
  const std::filesystem::path folder_;
  std::string chip_name_;
  std::filesystem::path levels_;  // where the kernel has a folder for each line of the chip
  std::unique_ptr<UsbipConnection> camera_;
  std::jthread carrier_;
};

}  // namespace geond::sim
