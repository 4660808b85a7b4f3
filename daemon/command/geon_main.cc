// SPDX-License-Identifier: Apache-2.0
// geon: describes scanned objects from files, and talks to geond.
#include <csignal>
#include <iostream>
#include <thread>

#include <pthread.h>
#include <unistd.h>

#include "daemon/command/command_line.h"

int main(int argc, char** argv) {
  // Ctrl-C is waited for on a thread of its own: the first asks the work to end, the second ends the program.
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGINT);
  sigaddset(&signals, SIGTERM);
  sigaddset(&signals, SIGUSR1);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  std::signal(SIGPIPE, SIG_IGN);

  std::stop_source stop;
  std::thread listener([&] {
    int signal = 0;
    while (sigwait(&signals, &signal) == 0 && signal != SIGUSR1) {
      if (stop.stop_requested()) _exit(1);
      stop.request_stop();
    }
  });
  const int code = geond::daemon::RunGeon({argv + 1, argv + argc}, stop.get_token(),
                                          {std::cout, std::cerr, isatty(STDERR_FILENO) == 1, STDIN_FILENO});
  pthread_kill(listener.native_handle(), SIGUSR1);
  listener.join();
  return code;
}
