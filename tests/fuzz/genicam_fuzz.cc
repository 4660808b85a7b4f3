// SPDX-License-Identifier: Apache-2.0
// Whatever description a camera has: features or a named error, never a crash, no endless loop. What its registers hold
// comes from the text itself.
#include <cstdint>
#include <string>
#include <string_view>

#include "core/base/error.h"
#include "drivers/genicam.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace geond;
  using namespace geond::drivers;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  genicam::Memory memory;
  int accesses = 0;
  memory.read = [&](std::uint64_t address, std::size_t count) {
    if (++accesses > 10000) throw DeviceError("fuzz", "read", "too many");
    if (count > 4096) throw DeviceError("fuzz", "read", "too much");
    std::vector<std::uint8_t> bytes;
    for (std::size_t i = 0; i < count; ++i) bytes.push_back(size == 0 ? 0 : data[(address + i) % size]);
    return bytes;
  };
  memory.write = [&](std::uint64_t, std::span<const std::uint8_t>) {
    if (++accesses > 10000) throw DeviceError("fuzz", "write", "too many");
  };
  const auto attempt = [](const auto& work) {
    try {
      work();
    } catch (const DeviceError&) {
    }
  };
  attempt([&] {
    const genicam::Description camera(text);
    for (const char* name : {"Width", "Gain", "PixelFormat", "AcquisitionStart", "DeviceModelName", "A", "B"}) {
      attempt([&] { camera.Available(name, memory); });
      attempt([&] { camera.ReadInteger(name, memory); });
      attempt([&] { camera.ReadFloat(name, memory); });
      attempt([&] { camera.ReadEnumeration(name, memory); });
      attempt([&] { camera.ReadString(name, memory); });
      attempt([&] { camera.WriteInteger(name, 3, memory); });
      attempt([&] { camera.WriteFloat(name, 0.5, memory); });
      attempt([&] { camera.WriteEnumeration(name, "Mono8", memory); });
      attempt([&] { camera.Execute(name, memory); });
      attempt([&] { camera.Entries(name); });
    }
  });
  return 0;
}
