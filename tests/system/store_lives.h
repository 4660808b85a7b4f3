// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <csignal>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

// Lives of the service on one store, each ended by a crash until the last, and what a client was told in them.
namespace geond::system_test {

struct Life {
  std::vector<std::string> lines;  // as store_child says them
  bool killed = false;

  std::string After(const std::string& word) const {
    for (const std::string& line : lines) {
      if (line.compare(0, word.size() + 1, word + " ") == 0) return line.substr(word.size() + 1);
    }
    return {};
  }
  bool Says(const std::string& word) const { return !After(word).empty(); }
  int Acknowledged() const {  // views, in this life
    int n = 0;
    for (const std::string& line : lines) n += line.compare(0, 5, "view ") == 0;
    return n;
  }
};

struct Crash {
  int at = 0;  // call of the losing disk; 0: none
  std::string loss = "nothing";
  std::uint64_t seed = 1;
  int kill_after_us = -1;  // SIGKILL from outside, so long after its start; -1: none
};

inline Life Live(const std::string& child, const std::filesystem::path& store, const Crash& crash) {
  int ends[2];
  if (pipe(ends) != 0) return {};
  const std::string at = std::to_string(crash.at), seed = std::to_string(crash.seed);
  const pid_t pid = fork();
  if (pid == 0) {
    dup2(ends[1], STDOUT_FILENO);
    close(ends[0]);
    close(ends[1]);
    execl(child.c_str(), child.c_str(), store.c_str(), at.c_str(), crash.loss.c_str(), seed.c_str(), nullptr);
    _exit(127);
  }
  close(ends[1]);
  if (crash.kill_after_us >= 0) {
    usleep(static_cast<useconds_t>(crash.kill_after_us));
    kill(pid, SIGKILL);
  }
  std::string text;
  char buffer[4096];
  for (ssize_t n; (n = read(ends[0], buffer, sizeof buffer)) > 0;) text.append(buffer, static_cast<std::size_t>(n));
  close(ends[0]);
  int status = 0;
  waitpid(pid, &status, 0);
  Life life;
  life.killed = WIFSIGNALED(status);
  for (std::size_t begin = 0, end; (end = text.find('\n', begin)) != std::string::npos; begin = end + 1) {
    life.lines.push_back(text.substr(begin, end - begin));
  }
  return life;
}

// Crash after crash on one new store, then a life to the end. Empty if nothing acknowledged was lost and the
// description is the expected one; else what is wrong.
inline std::string Survive(const std::string& child, const std::filesystem::path& store,
                           const std::vector<Crash>& crashes, const std::string& expected) {
  std::filesystem::remove_all(store);
  std::filesystem::remove_all(store.string() + ".lost");
  int safe = 0;
  bool begun = false;
  const auto judge = [&](const Life& life) -> std::string {
    if (life.Says("error")) return "error: " + life.After("error");
    if (life.Says("found")) {
      const std::string found = life.After("found");
      const int views = std::stoi(found.substr(found.find(' ') + 1));
      if (views < safe)
        return std::to_string(safe) + " views were acknowledged, " + std::to_string(views) + " are there";
      if (found.compare(0, 6, "failed") == 0 || found.compare(0, 7, "running") == 0) return "found " + found;
      safe = views;
    } else if (begun && life.Says("begun")) {  // a life that was killed before it could say anything has lost nothing
      return "the scan is gone";
    }
    safe += life.Acknowledged();
    begun = begun || life.Says("begun");
    if (life.Says("done") && life.After("done") != expected) return "another description: " + life.After("done");
    return {};
  };
  for (const Crash& crash : crashes) {
    if (const std::string wrong = judge(Live(child, store, crash)); !wrong.empty()) return wrong;
  }
  const Life last = Live(child, store, {});
  if (const std::string wrong = judge(last); !wrong.empty()) return wrong;
  if (!last.Says("done")) return "the last life ended without a description";
  for (const auto& entry : std::filesystem::recursive_directory_iterator(store)) {
    if (entry.path().extension() == ".part") return "left behind: " + entry.path().string();
  }
  std::filesystem::remove_all(store);
  std::filesystem::remove_all(store.string() + ".lost");
  return {};
}

}  // namespace geond::system_test
