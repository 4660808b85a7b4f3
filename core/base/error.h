// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stdexcept>
#include <string>

namespace geond {

// What went wrong in the world (a device, a file, a config), as one sentence for a person: the thing it happened to, the
// call that failed, the cause, and what to do about it. A caller's own mistake is std::invalid_argument instead.
class Error : public std::runtime_error {
 public:
  Error(std::string thing, std::string call, std::string cause, std::string remedy = {})
      : std::runtime_error(thing + ": " + call + ": " + cause + (remedy.empty() ? "" : ". " + remedy)),
        thing_(std::move(thing)), call_(std::move(call)), cause_(std::move(cause)), remedy_(std::move(remedy)) {}

  const std::string& thing() const { return thing_; }
  const std::string& call() const { return call_; }
  const std::string& cause() const { return cause_; }
  const std::string& remedy() const { return remedy_; }

 private:
  std::string thing_, call_, cause_, remedy_;
};

// A file is absent, unreadable, broken or of an unknown kind. The cause names the line or the byte.
class FileError : public Error { using Error::Error; };

// A configuration file says something that cannot be. The cause names line and key.
class ConfigError : public Error { using Error::Error; };

// A device refused, answered nonsense or vanished.
class DeviceError : public Error { using Error::Error; };

// A device did not answer, or a motion did not end, within its time.
class TimeoutError : public DeviceError { using DeviceError::DeviceError; };

// A person asked for the work to end. No failure.
class Cancelled : public std::exception {
 public:
  const char* what() const noexcept override { return "cancelled"; }
};

}  // namespace geond
