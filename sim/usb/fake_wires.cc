// SPDX-License-Identifier: Apache-2.0
#include "sim/usb/fake_wires.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstring>

#include "core/base/error.h"

namespace geond::sim {

pid_t StartBelow(const std::vector<std::string>& arguments, const std::string& preload,
                 const std::vector<std::string>& settings, const std::filesystem::path& log) {
  std::vector<std::string> environment = settings;
  std::string preloads = preload;
  for (char** entry = environ; *entry != nullptr; ++entry) {
    const std::string setting = *entry;
    if (setting.starts_with("LD_PRELOAD=")) {
      preloads.append(":").append(setting.substr(std::strlen("LD_PRELOAD=")));
    } else if (!setting.starts_with("UMOCKDEV_DIR=")) {
      environment.push_back(setting);
    }
  }
  environment.push_back(std::string("LD_PRELOAD=").append(preloads));
  const auto pointers = [](const std::vector<std::string>& texts) {
    std::vector<char*> list;
    for (const std::string& text : texts) list.push_back(const_cast<char*>(text.c_str()));
    list.push_back(nullptr);
    return list;
  };
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  if (!log.empty()) {
    posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, log.c_str(), O_WRONLY | O_CREAT | O_APPEND, 0600);
    posix_spawn_file_actions_adddup2(&actions, STDOUT_FILENO, STDERR_FILENO);
  }
  pid_t process = -1;
  const int error = posix_spawnp(&process, arguments.front().c_str(), &actions, nullptr, pointers(arguments).data(),
                                 pointers(environment).data());
  posix_spawn_file_actions_destroy(&actions);
  if (error != 0) throw FileError(arguments.front(), "start", std::strerror(error));
  return process;
}

int WaitFor(pid_t process) {
  int status = 0;
  if (waitpid(process, &status, 0) != process) return -1;
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

FakeWires::FakeWires(FakeBench& bench, const std::filesystem::path& folder)
    : bench_(bench), folder_(folder), gpio_(bench.chip(), (folder / "gpio").string()), usb_(*bench.camera()) {
  std::filesystem::remove(serial_device());
  std::filesystem::create_symlink(bench.drive().serial_device(), serial_device());
  bench.OnPlug([this](bool in) { in ? usb_.Plug() : usb_.Unplug(); });
}

FakeWires::~FakeWires() {
  bench_.OnPlug([camera = bench_.camera()](bool in) { camera->SetPlugged(in); });
}

pid_t FakeWires::Start(const std::vector<std::string>& arguments, const std::filesystem::path& log) const {
  return StartBelow(arguments, std::string(GEOND_FAKE_GPIO_LIBRARY) + ":" + FakeUsbPort::kPreload,
                    {"GEOND_FAKE_GPIO=" + (folder_ / "gpio").string(), "UMOCKDEV_DIR=" + usb_.folder()}, log);
}

}  // namespace geond::sim
