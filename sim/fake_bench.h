// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "sim/fake_camera.h"
#include "sim/fake_drive.h"
#include "sim/fake_gpio_chip.h"
#include "sim/sim_config.h"

namespace geond::sim {

// Lines of the fake bench's GPIO chip, with the names they have there. Loops that are closed when all is well are high
// then; the rest is on when high.
enum BenchLine : unsigned { kLaserLine, kMotorLine, kLampLine, kTriggerLine, kStopLine, kDoorLine, kBenchLines };
inline const std::vector<std::string> kBenchLineNames = {"LASER", "MOTOR", "LAMP", "TRIGGER", "STOP_LOOP", "DOOR_LOOP"};

// What a light meter and a hand on the table would have noticed.
struct BenchEvent {
  enum class Kind { kLaserOn, kLaserOff, kMotionBegins, kMotionEnds };
  Kind kind;
  std::chrono::steady_clock::time_point time;
};

// A bench of fakes at the wire, in real time: camera, drive and GPIO chip share the scene, the table and the wires of
// one simulated station, so that real drivers see through them what the twins see. The emergency stop cuts laser and
// motor in hardware, the door the laser; an image is taken only while the laser shines. Any thread.
class FakeBench {
 public:
  using Clock = std::chrono::steady_clock;

  // `drive_line`: settings of the serial line that the drive answers at; its position is the world's.
  explicit FakeBench(std::shared_ptr<SimStation> world, FakeDriveOptions drive_line = {},
                     FakeDrive::Transport transport = FakeDrive::Transport::kPseudoTerminal);
  ~FakeBench();
  FakeBench(const FakeBench&) = delete;
  FakeBench& operator=(const FakeBench&) = delete;

  SimStation& world() { return *world_; }
  const std::shared_ptr<FakeCamera>& camera() { return camera_; }
  FakeDrive& drive() { return *drive_; }
  FakeGpioChip& chip() { return chip_; }

  // Lets the bench do it by itself (unplugs where nothing else is said): what plugging the camera in and out means.
  void OnPlug(std::function<void(bool)> plug);
  // From now on, until set again; Fault::kNone mends the device. At the wire the words mean:
  //   rangefinder  off: unplugged. stuck: no frame comes. garbage: leaders without magic number. wrong: half the rows.
  //                slow: frames come 20 exposures late. delayed: 3 s late. intermittent: every second frame is lost.
  //   turntable    off: no reply. stuck: the motor does not turn. garbage: replies of rubbish. wrong: refuses each
  //   request.
  //                slow: a twentieth of the speed. delayed: replies come late. intermittent: every third reply is lost.
  //   lines        off: the chip is gone. stuck: outputs stay as they are. garbage: the emergency stop's line chatters.
  //                wrong: inputs read inverted. slow: each call takes half a second. delayed: inputs change a second
  //                late. intermittent: every second call fails.
  void SetFault(Device device, Fault fault);
  void SetEmergencyStop(bool pressed);
  void SetDoorOpen(bool open);

  // As if the motor's contactor were welded: the motor has power whatever its line says.
  void BridgeMotorContact(bool bridged);

  bool laser_shines() const;
  bool table_turns() const;
  std::vector<BenchEvent> TakeEvents();  // since the last time

 private:
  void Tick();
  void Synchronise();  // mutex_ held; not the camera
  void Note(bool shines, bool turns);

  const std::shared_ptr<SimStation> world_;
  const double radians_per_step_;
  FakeGpioChip chip_;
  std::unique_ptr<FakeDrive> drive_;
  std::shared_ptr<FakeCamera> camera_;
  std::function<void(bool)> plug_;
  mutable std::mutex mutex_;
  int triggers_ = 0;
  Fault lines_fault_ = Fault::kNone;
  bool bridged_ = false, chatter_ = false, shines_ = false, turns_ = false;
  bool stop_shown_ = false, door_shown_ = false;  // as the input lines have it
  Clock::time_point inputs_changed_{};
  std::vector<BenchEvent> events_;
  std::jthread ticker_;
};

}  // namespace geond::sim
