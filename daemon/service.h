// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <stop_token>
#include <string>
#include <variant>
#include <vector>

#include "daemon/access_tokens.h"
#include "daemon/calibration_store.h"
#include "daemon/config.h"
#include "daemon/open_station.h"
#include "daemon/robot/grasp.h"
#include "daemon/robot/robot_protocol.h"
#include "daemon/rpc.h"
#include "daemon/run_scan.h"
#include "daemon/scan_store.h"
#include "daemon/station.h"
#include "daemon/work_thread.h"

namespace geond::daemon {

// What geond does, whatever it is asked over: one station, one job at a time, the scans on disk, clients that want to be
// told. Made, used and destroyed on the I/O thread; it has a device thread and a compute thread of its own and hands values
// to and fro. Destruction stops what runs and leaves the station safe.
class Service {
 public:
  enum class State { kIdle, kHoming, kResetting, kAcquiring, kModelling };

  // `to_io` hands a task to the I/O thread. Throws FileError if the store cannot be opened.
  Service(const Config& config, OpenedStation station, Post to_io);
  ~Service();
  Service(const Service&) = delete;
  Service& operator=(const Service&) = delete;

  const RpcTable& methods() const { return methods_; }
  // Answers a line of a client: `respond` gets the response, once, now or later, or never, for a notification. A client that
  // asks too often is told so instead.
  void Answer(std::string_view line, Client& client, const std::function<void(std::string)>& respond);
  const Config& config() const { return config_; }
  // Takes over the keys that can change while it runs.
  void Reload(const Config& config);

  // The line that greets a new connection.
  std::string Greeting() const;
  // Who may call from outside this machine's Unix socket; without tokens everybody who can connect may do everything.
  const AccessTokens& tokens() const { return tokens_; }
  Role FirstRole(bool by_unix_socket) const { return by_unix_socket || tokens_.empty() ? Role::kAdmin : Role::kNone; }
  // Clients that may subscribe to events; the pointer must stay good until RemoveClient.
  void AddClient(Client* client) { clients_.insert(client); }
  void RemoveClient(Client* client) { clients_.erase(client); }
  std::size_t clients() const { return clients_.size(); }

  // What a robot controller is told. Never throws.
  RobotRecord AnswerRobot(const RobotRequest& request);

  // A file of a done scan by its name, to be shown; empty if there is none.
  std::filesystem::path ScanFile(int scan, const std::string& name) const;
  // Packs a scan into an archive, or takes one in and removes it; off the I/O thread, answered on it. An archive that is
  // there already is answered at once.
  using PathReply = std::function<void(std::variant<std::filesystem::path, RpcError> archive)>;
  void ExportScan(int scan, const PathReply& reply);
  void ImportScan(const std::filesystem::path& archive, const Reply& reply);
  // Where an archive may be put that is to be taken in.
  std::filesystem::path ImportFile();

  // Counters and gauges as Prometheus reads them.
  std::string Metrics() const;
  // Counts what the sockets did: "too_many_clients", "slow_reader", ...
  void CountRefusal(const std::string& why) { ++refusals_[why]; }
  // Removes scans that the limits of the store want gone; to be called every few minutes. While the clock has just been
  // set, ages mean nothing and nobody is removed for his.
  void KeepHouse(std::chrono::system_clock::time_point now, std::chrono::steady_clock::time_point steady_now);

  // To be called when the wires have something to say: reads them and stops everything if they forbid work.
  void OnLinesEvent();
  int lines_event_fd() { return station_->lines().event_fd(); }
  // Stops what runs, at once.
  void StopAll(const std::string& reason);

  State state() const { return state_; }
  // Where the page is, for clients that want files; empty: nowhere.
  void SetHttpUrl(const std::string& url) { http_url_ = url; }
  std::string StatusText() const;  // one line, for the service manager
  // True as long as no thread hangs: one with work must have made progress since the last call.
  bool ThreadsAlive();

 private:
  // A scan from request to answer.
  struct Job {
    int id = 0;
    std::stop_source stop;
    std::string step = "acquire";
    int done = 0, total = 0, views_taken = 0, views = 0;
    std::string stop_reason;  // of a stop that is a fault, else empty
  };

  // service_methods.cc
  void AddMethods();
  void AddStationMethods();
  void AddScanMethods();
  void AddStoreMethods();  // service_store.cc
  void AddResultMethods();
  void AddSimulationMethods();
  Json StatusJson();
  Json ScanJson(const ScanSummary& scan) const;
  std::shared_ptr<const Json> Description(int id);
  std::shared_ptr<const Json> Grasps(int id);

  // service_calibration.cc
  void AddCalibrationMethods();
  void LoadCalibration();  // the one in force, or why it cannot be used
  StationGeometry Geometry() const;  // as calibrated, else as configured
  Json CalibrationStatus() const;
  void PlaceCalibrationTarget(int number, bool check, int views, const Reply& reply);
  void SolveCalibration(int number, const Reply& reply);

  // service_robot.cc
  std::optional<Pose> TableInRobot() const;
  RobotStatus StateForRobot() const;
  void FillObject(const RobotRequest& request, RobotRecord& record);
  int ScanParameter(const Json& params, bool done) const;  // the scan meant, by default the last
  ScanSummary FindScan(int id) const;                      // throws RpcError if there is none
  void Discard(int id);

  // service_jobs.cc
  Json StartScan(int views, double first_angle, const std::string& label);
  Json ResumeScan(int id);
  void Launch(ScanRecorder recorder, ScanPlan plan, int id);
  void Acquired(const std::shared_ptr<Job>& job, const ScanRecorder& recorder, std::shared_ptr<ScanResult> result);
  void Finished(const std::shared_ptr<Job>& job, const ScanRecorder& recorder, std::exception_ptr failure);
  void CountSteps(int id);  // service_metrics.cc
  void OnProgress(const std::shared_ptr<Job>& job, const std::string& step, int done, int total);
  StepObserver Observer(const std::shared_ptr<Job>& job, WorkThread& thread);
  void RunOnDevice(State state, std::function<void(std::stop_token)> work, const Reply& reply);
  void RefuseIfBusy() const;
  void RefuseIfUnsafe() const;
  ModelOptions MakeModelOptions() const;
  Gripper MakeGripper() const;

  void OnDeviceFault(const std::string& words);
  void Enter(State state);
  void Publish(const std::string& event, Json params);
  void TakeSnapshot();  // on the device thread: hands the devices' state over
  // Hands a task to the I/O thread that is dropped if the service is gone by then.
  void OnIo(std::function<void()> task);

  Config config_;
  const Post to_io_;
  const std::chrono::steady_clock::time_point started_ = std::chrono::steady_clock::now();
  std::shared_ptr<Service*> self_ = std::make_shared<Service*>(this);  // gone when the service is
  const AccessTokens tokens_;
  ScanStore store_;
  const CalibrationStore calibrations_;
  std::optional<calib::StationCalibration> calibration_;
  std::string calibration_problem_;  // why there is one but it is not used
  std::shared_ptr<sim::SimStation> simulation_;
  std::unique_ptr<Station> station_;
  RpcTable methods_;
  std::string http_url_;
  std::set<Client*> clients_;
  std::uint64_t events_ = 0;
  std::map<std::string, int> scans_ended_, refusals_;  // by state and by reason, since the start
  std::uint64_t requests_ = 0, views_ = 0, faults_ = 0;
  std::optional<std::chrono::system_clock::duration> clock_offset_;  // of the wall clock against the steady one
  std::uint64_t imports_ = 0;
  std::map<std::string, double> step_seconds_;  // of the last scan
  std::vector<double> residuals_mm_;            // of its parts

  State state_ = State::kIdle;
  std::uint64_t hazards_ = 0;  // how often something has forbidden work
  std::string latched_;  // why nothing may move until station.reset; empty: it may
  std::shared_ptr<Job> job_;
  std::stop_source device_stop_;
  std::vector<drivers::DeviceInfo> devices_;
  std::optional<double> table_angle_;
  std::map<int, std::shared_ptr<const Json>> descriptions_, grasps_;  // of scans asked for lately
  std::uint64_t device_seen_ = 0, compute_seen_ = 0;

  // Last, so that they end first: their tasks use what is above.
  WorkThread device_thread_;
  WorkThread compute_thread_;
};

// {grasps [{part (its id), pose in T, opening_mm, clearance_mm, quality, reason}]}, best first a part.
Json GraspsJson(const ObjectDescription& description, const Gripper& gripper);
std::string_view StateName(Service::State state);  // "idle", "homing", "resetting", "acquiring", "modelling"

}  // namespace geond::daemon
