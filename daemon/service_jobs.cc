// SPDX-License-Identifier: Apache-2.0
#include <numbers>

#include "core/base/error.h"
#include "daemon/log.h"
#include "daemon/service.h"
#include "sim/scene.h"

namespace geond::daemon {
namespace {

using Code = RpcError::Code;

// The device that a failure is about; empty: none.
std::string DeviceOf(const std::exception_ptr& failure) {
  try {
    std::rethrow_exception(failure);
  } catch (const DeviceError& error) {
    return error.thing();
  } catch (...) {
    return "";
  }
}

}  // namespace

void Service::RefuseIfBusy() const {
  if (state_ == State::kIdle) return;
  throw RpcError(Code::kBusy, "the station is " + std::string(StateName(state_)),
                 job_ ? "Wait for scan " + std::to_string(job_->id) + " or cancel it (scan.cancel)" : "Try again shortly");
}

void Service::RefuseIfUnsafe() const {
  if (!latched_.empty()) {
    throw RpcError(Code::kUnsafe, "the station is stopped: " + latched_,
                   "Remove the cause, see that nobody is in danger, then reset the station (station.reset)");
  }
  const std::string hazard = station_->Hazard();
  if (!hazard.empty()) {
    throw RpcError(Code::kUnsafe, hazard, "Release the emergency stop, close the door, then reset the station");
  }
}

ModelOptions Service::MakeModelOptions() const {
  ModelOptions options;
  options.tessellate.triangles = config_.scan_triangles;
  options.segment.detail = config_.scan_detail;
  options.integrate.threads = options.tessellate.threads = options.charge.threads = options.fit.threads =
      config_.scan_threads;
  return options;
}

Gripper Service::MakeGripper() const {
  Gripper gripper;
  gripper.max_opening = 1e-3 * config_.gripper_opening_mm;
  gripper.finger_length = 1e-3 * config_.gripper_finger_length_mm;
  gripper.finger_width = 1e-3 * config_.gripper_finger_width_mm;
  gripper.finger_thickness = 1e-3 * config_.gripper_finger_thickness_mm;
  gripper.clearance = 1e-3 * config_.gripper_clearance_mm;
  return gripper;
}

void Service::RunOnDevice(State state, std::function<void(std::stop_token)> work, const Reply& reply) {
  RefuseIfBusy();
  device_stop_ = {};
  Enter(state);
  device_thread_.Post([this, state, work = std::move(work), stop = device_stop_.get_token(), reply, hazards = hazards_] {
    std::exception_ptr failure;
    try {
      work(stop);
    } catch (...) {
      failure = std::current_exception();
    }
    TakeSnapshot();
    OnIo([this, state, failure, reply, hazards] {
      // What happened while it was reset wants a reset of its own.
      if (!failure && state == State::kResetting && hazards == hazards_) latched_.clear();
      Enter(State::kIdle);
      if (failure) {
        const RpcError error = ToRpcError(failure);
        if (error.code() == Code::kDeviceFailed) ++faults_;
        Log(spdlog::level::warn, {0, DeviceOf(failure), std::string(StateName(state))}, error.what());
        reply(error);
      } else {
        reply(StatusJson());
      }
    });
  });
}

// Hands progress to the I/O thread, no more often than it would show.
StepObserver Service::Observer(const std::shared_ptr<Job>& job, WorkThread& thread) {
  struct Last {
    std::string step;
    int percent = -1;
  };
  return [this, job, &thread, last = std::make_shared<Last>()](std::string_view step, int done, int total) {
    thread.Tick();
    const int percent = total > 0 ? static_cast<int>(100LL * done / total) : 0;
    if (last->step == step && last->percent == percent) return;
    *last = {std::string(step), percent};
    OnIo([this, job, name = std::string(step), done, total] { OnProgress(job, name, done, total); });
  };
}

void Service::OnProgress(const std::shared_ptr<Job>& job, const std::string& step, int done, int total) {
  job->step = step;
  job->done = done;
  job->total = total;
  Publish("progress", {{"scan", job->id}, {"step", step}, {"done", done}, {"total", total}});
}

Json Service::StartScan(int views, double first_angle, const std::string& label) {
  RefuseIfBusy();
  RefuseIfUnsafe();
  ScanRecorder recorder = store_.Begin(views, first_angle, label);
  ScanPlan plan;
  plan.views = views;
  plan.first_angle = first_angle;
  Launch(std::move(recorder), std::move(plan), store_.newest());
  return {{"scan", job_->id}, {"state", ScanStateName(ScanState::kRunning)}};
}

Json Service::ResumeScan(int id) {
  RefuseIfBusy();
  const ScanSummary scan = FindScan(id);
  if (scan.state == ScanState::kDone) {
    throw RpcError(Code::kUnavailable, "scan " + std::to_string(id) + " is done", "Ask for its description");
  }
  ScanPlan plan;
  plan.views = scan.views;
  plan.first_angle = scan.first_angle;
  plan.taken = ScanRecorder(store_.Folder(id)).Views();
  if (static_cast<int>(plan.taken.size()) < plan.views) RefuseIfUnsafe();
  Launch(store_.Resume(id), std::move(plan), id);
  return {{"scan", id}, {"state", ScanStateName(ScanState::kRunning)}};
}

void Service::Launch(ScanRecorder recorder, ScanPlan plan, int id) {
  job_ = std::make_shared<Job>();
  job_->id = id;
  job_->views = job_->total = plan.views;
  job_->views_taken = static_cast<int>(plan.taken.size());
  plan.registering.threads = config_.scan_threads;
  plan.calibration = calibration_;
  Log(spdlog::level::info, {id, "", "acquire"}, "scan " + std::to_string(id) + " begins: " + std::to_string(plan.views) +
                                                    " views, " + std::to_string(plan.taken.size()) + " of them there");
  Enter(State::kAcquiring);
  Publish("scan", {{"scan", id}, {"state", ScanStateName(ScanState::kRunning)}});
  device_thread_.Post([this, job = job_, recorder = std::move(recorder), plan = std::move(plan)] {
    const auto keep = [&](int view, const Exposure& exposure) {
      recorder.KeepView(view, exposure);
      TakeSnapshot();
      OnIo([this, job, view, angle = exposure.table_angle] {
        job->views_taken = view + 1;
        ++views_;
        Publish("view", {{"scan", job->id},
                         {"view", view},
                         {"views", job->views},
                         {"angle_deg", angle * 180.0 / std::numbers::pi}});
      });
    };
    std::exception_ptr failure;
    std::shared_ptr<ScanResult> result;
    try {
      result = std::make_shared<ScanResult>(
          RunScan(*station_, plan, keep, job->stop.get_token(), Observer(job, device_thread_)));
      if (simulation_) {
        result->scan.seed = simulation_->options().seed;
        result->scan.truth = sim::TruthJson(simulation_->scene());
      }
    } catch (...) {
      failure = std::current_exception();
    }
    TakeSnapshot();
    OnIo([this, job, recorder, result, failure] {
      if (failure) {
        Finished(job, recorder, failure);
      } else {
        Acquired(job, recorder, result);
      }
    });
  });
}

void Service::Acquired(const std::shared_ptr<Job>& job, const ScanRecorder& recorder, std::shared_ptr<ScanResult> result) {
  Enter(State::kModelling);
  compute_thread_.Post([this, job, recorder, result = std::move(result), options = MakeModelOptions(),
                        gripper = MakeGripper(), picture = config_.scan_picture] {
    std::exception_ptr failure;
    try {
      const StepObserver on_step = Observer(job, compute_thread_);
      ObjectModel model = BuildObjectModel(result->views, options, job->stop.get_token(), on_step);
      for (const std::string& note : result->registration.notes) model.description.notes.push_back(note);
      on_step("store", 0, 0);
      recorder.KeepGrasps(GraspsJson(model.description, gripper).dump());
      recorder.Finish(result->scan, model, picture);
    } catch (...) {
      failure = std::current_exception();
    }
    OnIo([this, job, recorder, failure] { Finished(job, recorder, failure); });
  });
}

void Service::Finished(const std::shared_ptr<Job>& job, const ScanRecorder& recorder, std::exception_ptr failure) {
  Json event = {{"scan", job->id}};
  if (failure) {
    RpcError error = ToRpcError(failure);
    if (error.code() == Code::kInternal) error = RpcError(Code::kScanFailed, error.what(), "Look at the stored scan");
    if (job->stop.stop_requested()) error = RpcError(Code::kCancelled, "cancelled");
    if (!job->stop_reason.empty()) {
      error = RpcError(Code::kUnsafe, "the scan was stopped: " + job->stop_reason,
                       "Reset the station, then resume the scan");
    }
    const ScanState outcome = error.code() == Code::kCancelled ? ScanState::kCancelled : ScanState::kFailed;
    try {
      recorder.Abandon(outcome, outcome == ScanState::kFailed ? error.what() : "");
    } catch (const FileError& unwritten) {
      Log(spdlog::level::err, {job->id, "", "store"}, unwritten.what());
    }
    if (error.code() == Code::kDeviceFailed) ++faults_;
    Log(spdlog::level::warn, {job->id, DeviceOf(failure), job->step},
        "scan " + std::to_string(job->id) + " " + std::string(ScanStateName(outcome)) + ": " + error.what());
    event["state"] = ScanStateName(outcome);
    event["error"] = error.ToJson();
  }
  try {
    store_.Refresh(job->id);
  } catch (const FileError& unwritten) {
    Log(spdlog::level::err, {job->id, "", "store"}, unwritten.what());  // its folder tells whoever asks
  }
  if (!failure) {
    CountSteps(job->id);
    const ScanSummary scan = FindScan(job->id);
    Log(spdlog::level::info, {job->id, "", ""},
        "scan " + std::to_string(job->id) + " is " + std::string(ScanStateName(scan.state)) + ": " +
            std::to_string(scan.types.size()) + " parts");
    event["state"] = ScanStateName(scan.state);
    event["n_parts"] = scan.types.size();
    event["types"] = scan.types;
  }
  ++scans_ended_[event["state"].get<std::string>()];
  job_.reset();
  Enter(State::kIdle);
  Publish("scan", event);
}

}  // namespace geond::daemon
