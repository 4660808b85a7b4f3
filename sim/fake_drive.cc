// SPDX-License-Identifier: Apache-2.0
#include "sim/fake_drive.h"

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cmath>
#include <cstdint>
#include <mutex>
#include <stdexcept>
#include <thread>

#include <arpa/inet.h>
#include <fcntl.h>
#include <modbus/modbus.h>
#include <poll.h>
#include <pty.h>
#include <sys/socket.h>
#include <termios.h>
#include <unistd.h>

namespace geond::sim {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kRegisters = 0x1400;
constexpr int kDirectData = 0x0058, kDirectDataWords = 16, kInput = 0x007C, kStatus = 0x007E, kAlarm = 0x0080, kPosition = 0x00CC,
              kAlarmReset = 0x0180, kTimeout = 0x138A;
constexpr std::uint32_t kServoOn = 1u << 0, kQuickStop = 1u << 4, kStop = 1u << 5, kHome = 1u << 20;
constexpr std::uint32_t kStatusOn = 1u << 0, kStatusPositionKnown = 1u << 4, kStatusAlarm = 1u << 7, kStatusInPosition = 1u << 9,
                        kStatusMoving = 1u << 13;
constexpr int kCommunicationAlarm = 0x85;
constexpr double kStepsPerTurn = 36000.0;
constexpr double kHomingSpeed = 18000.0;  // steps/s

// The motor and what it was told; time comes from outside.
struct Motor {
  double position = 1234.0, target = 1234.0, speed = 0.0;  // steps, steps/s
  bool on = false, homed = false, homing = false;
  bool wanted = false, powered = true;  // to be excited, by command; and able to
  int alarm = 0;
  Clock::time_point now{}, heard{}, lifetime_end = Clock::time_point::max();

  bool moving() const { return alarm == 0 && on && position != target; }

  // `pace`: share of the speed that it really turns at.
  void Advance(Clock::time_point time, std::chrono::milliseconds communication_timeout, double pace) {
    // Nothing is looked at more often than it is asked for, so the end of a time limit is found on the way.
    const Clock::time_point silence = communication_timeout.count() > 0 ? heard + communication_timeout : Clock::time_point::max();
    const Clock::time_point end = std::min({time, std::max(now, silence), std::max(now, lifetime_end)});
    if (moving() && pace > 0.0) {
      const double step = pace * speed * std::chrono::duration<double>(end - now).count(), left = target - position;
      position = std::abs(left) <= step ? target : position + std::copysign(step, left);
    }
    if (position == target) {
      lifetime_end = Clock::time_point::max();
      if (homing) homing = false, homed = true;
    }
    if (on && alarm == 0 && (time > silence || time > lifetime_end)) Alarm(kCommunicationAlarm);
    now = time;
  }
  void Alarm(int code) {
    alarm = code;
    target = position;
    homing = false;
    lifetime_end = Clock::time_point::max();
  }
};

}  // namespace

class FakeDrive::Server {
 public:
  Server(Transport transport, const FakeDriveOptions& options) : options_(options) {
    motor_.position = motor_.target = options.position;
    if (transport == Transport::kTcp) {
      context_ = modbus_new_tcp("127.0.0.1", 0);
      Listen();
    } else {
      int slave = -1;
      char name[64];
      termios raw{};
      cfmakeraw(&raw);
      if (openpty(&connection_, &slave, name, &raw, nullptr) != 0) throw std::runtime_error("no pseudo-terminal can be had");
      terminal_ = name;
      keep_open_ = slave;  // so that the terminal lives on between two masters
      context_ = modbus_new_rtu(name, 115200, 'N', 8, 1);
      modbus_set_socket(context_, connection_);
    }
    modbus_set_slave(context_, options.unit);
    registers_ = modbus_mapping_new(0, 0, kRegisters, 0);
    motor_.now = motor_.heard = Clock::now();
    thread_ = std::jthread([this](std::stop_token stop) { Serve(stop); });
  }
  ~Server() {
    thread_.request_stop();
    thread_.join();
    for (int fd : {listener_, connection_, keep_open_}) {
      if (fd >= 0) close(fd);
    }
    modbus_mapping_free(registers_);
    modbus_free(context_);
  }

  std::string terminal_;
  int port_ = 0;
  std::atomic<WireFault> fault_{WireFault::kNone};
  std::atomic<int> exception_{MODBUS_EXCEPTION_SLAVE_OR_SERVER_FAILURE};
  std::atomic<bool> unplug_{false};

  Motor Snapshot() {
    const std::lock_guard lock(mutex_);
    Advance();
    return motor_;
  }
  void SetPower(bool on) {
    const std::lock_guard lock(mutex_);
    if (motor_.powered == on) return;
    Advance();
    motor_.powered = on;
    motor_.on = on && motor_.wanted && motor_.alarm == 0;
    if (motor_.on) return;
    motor_.homing = false;
    motor_.target = motor_.position;
  }
  void RaiseAlarm(int code) {
    const std::lock_guard lock(mutex_);
    motor_.Alarm(code);
  }

 private:
  void Advance() {
    const WireFault fault = fault_;
    motor_.Advance(Clock::now(), Timeout(), fault == WireFault::kStuck ? 0.0 : fault == WireFault::kCrawling ? 0.05 : 1.0);
  }

  // Whether the line's settings are those that it listens at. A pseudo-terminal has no parity on its wire, but shows in
  // its settings what the program asked for.
  bool UnderstandsLine() const {
    if (options_.baud == 0 || listener_ >= 0) return true;
    termios line{};
    if (tcgetattr(connection_, &line) != 0) return true;
    const char parity = (line.c_iflag & INPCK) == 0 ? 'N' : (line.c_cflag & PARODD) != 0 ? 'O' : 'E';
    return parity == options_.parity && cfgetospeed(&line) == Speed(options_.baud);
  }
  static speed_t Speed(int baud) {
    switch (baud) {
      case 9600: return B9600;
      case 19200: return B19200;
      case 38400: return B38400;
      case 57600: return B57600;
      case 115200: return B115200;
      default: return B230400;
    }
  }

  void Listen() {
    listener_ = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    if (bind(listener_, reinterpret_cast<sockaddr*>(&address), size) != 0 || listen(listener_, 1) != 0 ||
        getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size) != 0) {
      throw std::runtime_error("no loopback port can be had");
    }
    port_ = ntohs(address.sin_port);
  }

  void Serve(std::stop_token stop) {
    constexpr int kLookUpMs = 5;  // how soon a stop is seen
    while (!stop.stop_requested()) {
      if (unplug_.exchange(false)) HangUp();
      const int watched = connection_ >= 0 ? connection_ : listener_;
      pollfd ready{watched, POLLIN, 0};
      if (poll(&ready, 1, kLookUpMs) <= 0) continue;
      if (watched == listener_) {
        connection_ = accept(listener_, nullptr, nullptr);
        modbus_set_socket(context_, connection_);
        continue;
      }
      std::uint8_t query[MODBUS_TCP_MAX_ADU_LENGTH];
      const int length = modbus_receive(context_, query);
      if (length > 0) {
        Answer(query, length, stop);
      } else if (length < 0 && listener_ >= 0) {
        HangUp();
      }
    }
  }
  void HangUp() {
    if (listener_ >= 0) {
      if (connection_ >= 0) close(connection_);
      connection_ = -1;
    } else {
      close(keep_open_);
      close(connection_);
      keep_open_ = connection_ = -1;
    }
  }

  void Answer(std::uint8_t* query, int length, const std::stop_token& stop) {
    const WireFault fault = fault_;
    ++requests_;
    if (!UnderstandsLine()) return;
    if (fault == WireFault::kOff || (fault == WireFault::kIntermittent && requests_ % 3 == 0)) return;
    if (fault == WireFault::kSlow) Wait(options_.slow, stop);
    if (fault == WireFault::kDelayed) Wait(options_.late, stop);
    if (fault == WireFault::kGarbage) return Send({0x00, 0xff, 0x5a, 0xa5, 0x13, 0x37, 0x00, 0x01, 0x02});
    if (fault == WireFault::kBadChecksum) return Send({query[0], query[1], 0x04, 0x00, 0x00, 0x00, 0x00, 0xde, 0xad});
    if (fault == WireFault::kHalfFrame) return Send({query[0], query[1], 0x04, 0x00});
    if (fault == WireFault::kWrong) {
      modbus_reply_exception(context_, query, static_cast<unsigned>(exception_.load()));
      return;
    }
    const std::lock_guard lock(mutex_);
    Advance();
    motor_.heard = motor_.now;
    Publish();
    if (fault == WireFault::kWrongUnit) {
      const int offset = modbus_get_header_length(context_) - 1;
      query[offset] ^= 0x40;
    }
    modbus_reply(context_, query, length, registers_);
    const int offset = modbus_get_header_length(context_);
    if (query[offset] == MODBUS_FC_WRITE_MULTIPLE_REGISTERS) Obey(query[offset + 1] << 8 | query[offset + 2], query[offset + 3] << 8 | query[offset + 4]);
  }
  void Send(std::initializer_list<std::uint8_t> bytes) {
    [[maybe_unused]] const ssize_t n = write(connection_, bytes.begin(), bytes.size());
  }
  static void Wait(std::chrono::milliseconds time, const std::stop_token& stop) {
    const Clock::time_point end = Clock::now() + time;
    while (Clock::now() < end && !stop.stop_requested()) poll(nullptr, 0, 1);
  }

  std::uint32_t Get(int address) const {
    return std::uint32_t{registers_->tab_registers[address]} << 16 | registers_->tab_registers[address + 1];
  }
  void Set(int address, std::uint32_t value) {
    registers_->tab_registers[address] = static_cast<std::uint16_t>(value >> 16);
    registers_->tab_registers[address + 1] = static_cast<std::uint16_t>(value & 0xffff);
  }
  std::chrono::milliseconds Timeout() const { return std::chrono::milliseconds(Get(kTimeout)); }

  void Publish() {
    std::uint32_t status = 0;
    if (motor_.on) status |= kStatusOn;
    if (motor_.homed) status |= kStatusPositionKnown;
    if (motor_.alarm) status |= kStatusAlarm;
    if (motor_.moving()) status |= kStatusMoving;
    if (!motor_.moving()) status |= kStatusInPosition;
    Set(kStatus, status);
    Set(kAlarm, static_cast<std::uint32_t>(motor_.alarm));
    Set(kPosition, static_cast<std::uint32_t>(static_cast<std::int32_t>(std::llround(motor_.position))));
  }

  // What the motor does about registers just written.
  void Obey(int address, int count) {
    const auto wrote = [&](int first, int words) { return address < first + words && address + count > first; };
    if (wrote(kAlarmReset, 2) && Get(kAlarmReset) == 1) motor_.alarm = 0;
    if (wrote(kInput, 2)) {
      const std::uint32_t input = Get(kInput);
      motor_.wanted = (input & kServoOn) != 0;
      motor_.on = motor_.wanted && !motor_.alarm && motor_.powered;
      if (input & (kStop | kQuickStop)) {
        motor_.target = motor_.position;
        motor_.homing = false;
        motor_.lifetime_end = Clock::time_point::max();
      } else if ((input & kHome) && !motor_.homing && !motor_.homed) {
        motor_.homing = true;
        motor_.target = 0.0;
        motor_.speed = kHomingSpeed;
      }
    }
    if (wrote(kDirectData, kDirectDataWords) && registers_->tab_registers[kDirectData + 15] == 1) {
      registers_->tab_registers[kDirectData + 15] = 0;
      if (!motor_.on || motor_.alarm) return;
      motor_.target = static_cast<std::int32_t>(Get(kDirectData + 4));
      motor_.speed = std::abs(static_cast<std::int32_t>(Get(kDirectData + 6))) * kStepsPerTurn / 60.0;
      const int lifetime = registers_->tab_registers[kDirectData + 14];
      motor_.lifetime_end = lifetime > 0 && motor_.target != motor_.position ? motor_.now + std::chrono::milliseconds(lifetime)
                                                                              : Clock::time_point::max();
    }
  }

  const FakeDriveOptions options_;
  modbus_t* context_ = nullptr;
  modbus_mapping_t* registers_ = nullptr;
  int listener_ = -1, connection_ = -1, keep_open_ = -1;
  int requests_ = 0;
  std::mutex mutex_;
  Motor motor_;
  std::jthread thread_;
};

FakeDrive::FakeDrive(Transport transport, const FakeDriveOptions& options)
    : server_(std::make_unique<Server>(transport, options)) {}
FakeDrive::~FakeDrive() = default;
std::string FakeDrive::serial_device() const { return server_->terminal_; }
int FakeDrive::port() const { return server_->port_; }
void FakeDrive::SetFault(WireFault fault) { server_->fault_ = fault; }
void FakeDrive::SetException(int code) { server_->exception_ = code; }
void FakeDrive::RaiseAlarm(int code) { server_->RaiseAlarm(code); }
double FakeDrive::position() const { return server_->Snapshot().position; }
bool FakeDrive::moving() const { return server_->Snapshot().moving(); }
bool FakeDrive::enabled() const { return server_->Snapshot().on; }
void FakeDrive::SetPower(bool on) { server_->SetPower(on); }
void FakeDrive::Unplug() { server_->unplug_ = true; }

}  // namespace geond::sim
