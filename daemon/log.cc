// SPDX-License-Identifier: Apache-2.0
#include "daemon/log.h"

#include <cstdlib>
#include <memory>
#include <mutex>

#include <spdlog/sinks/base_sink.h>
#include <spdlog/sinks/ringbuffer_sink.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#define SD_JOURNAL_SUPPRESS_LOCATION
#include <sys/stat.h>
#include <systemd/sd-journal.h>
#include <unistd.h>

namespace geond::daemon {
namespace {

constexpr std::size_t kLinesKept = 1000;

// Of the line that this thread is logging; the sinks are called on it.
thread_local const LogSubject* current_subject = nullptr;

std::shared_ptr<spdlog::sinks::ringbuffer_sink_mt>& Kept() {
  static std::shared_ptr<spdlog::sinks::ringbuffer_sink_mt> kept;
  return kept;
}

int Priority(spdlog::level::level_enum level) {
  switch (level) {
    case spdlog::level::critical:
      return 2;
    case spdlog::level::err:
      return 3;
    case spdlog::level::warn:
      return 4;
    case spdlog::level::info:
      return 6;
    default:
      return 7;
  }
}

// Sends a line with its subject as fields of its own.
class JournalSink : public spdlog::sinks::base_sink<std::mutex> {
 protected:
  void sink_it_(const spdlog::details::log_msg& line) override {
    std::vector<std::string> fields = {"MESSAGE=" + std::string(line.payload.data(), line.payload.size()),
                                       "PRIORITY=" + std::to_string(Priority(line.level)), "SYSLOG_IDENTIFIER=geond"};
    if (current_subject) {
      if (current_subject->scan > 0) fields.push_back("GEOND_SCAN=" + std::to_string(current_subject->scan));
      if (!current_subject->device.empty()) fields.push_back("GEOND_DEVICE=" + current_subject->device);
      if (!current_subject->step.empty()) fields.push_back("GEOND_STEP=" + current_subject->step);
    }
    std::vector<iovec> parts;
    for (std::string& field : fields) parts.push_back({field.data(), field.size()});
    sd_journal_sendv(parts.data(), static_cast<int>(parts.size()));
  }
  void flush_() override {}
};

// Whether standard error is the stream that journald gave us.
bool JournalListens() {
  const char* stream = std::getenv("JOURNAL_STREAM");
  struct stat status {};
  if (!stream || fstat(STDERR_FILENO, &status) != 0) return false;
  return std::string(stream) == std::to_string(status.st_dev) + ":" + std::to_string(status.st_ino);
}

}  // namespace

void OpenLog(const std::string& level) {
  Kept() = std::make_shared<spdlog::sinks::ringbuffer_sink_mt>(kLinesKept);
  spdlog::sink_ptr out;
  if (JournalListens()) {
    out = std::make_shared<JournalSink>();
  } else {
    out = std::make_shared<spdlog::sinks::stderr_color_sink_mt>();
  }
  spdlog::set_default_logger(
      std::make_shared<spdlog::logger>("geond", spdlog::sinks_init_list{std::move(out), Kept()}));
  spdlog::set_level(spdlog::level::from_str(level));
}

void Log(spdlog::level::level_enum level, const LogSubject& subject, const std::string& sentence) {
  current_subject = &subject;
  spdlog::log(level, "{}", sentence);
  current_subject = nullptr;
}

std::vector<std::string> LogTail(std::size_t limit) {
  std::vector<std::string> lines = Kept() ? Kept()->last_formatted(limit) : std::vector<std::string>();
  for (std::string& line : lines) {
    while (!line.empty() && (line.back() == '\n' || line.back() == '\r')) line.pop_back();
  }
  return lines;
}

}  // namespace geond::daemon
