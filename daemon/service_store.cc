// SPDX-License-Identifier: Apache-2.0
// What the service does with stored scans: lists, pins, removes, hands out and takes in.
#include <algorithm>

#include "core/base/error.h"
#include "daemon/log.h"
#include "daemon/scan_archive.h"
#include "daemon/service.h"

namespace geond::daemon {
namespace {

namespace fs = std::filesystem;
using Code = RpcError::Code;

// A step of the wall clock against the steady one that is no drift.
constexpr auto kClockStep = std::chrono::minutes(5);
// How long an archive stays for somebody to fetch it.
constexpr auto kExportKept = std::chrono::hours(1);

const std::vector<RpcParameter>& PageParameters() {
  static const std::vector<RpcParameter> parameters = {
      {"before", "integer", "Only scans with a smaller number: the cursor of the answer before", false, 1, 1e9, {}},
      {"limit", "integer", "At most so many, newest first", false, 1, 1000, {}}};
  return parameters;
}

// One page of scans, and in `next` the cursor of the page after it, null at the end.
std::vector<ScanSummary> Page(const ScanStore& store, const Json& params, bool done, Json& next) {
  ScanFilter filter;
  filter.before = params.value("before", 0);
  filter.limit = params.value("limit", std::size_t{100}) + 1;
  filter.done = done;
  std::vector<ScanSummary> scans = store.List(filter);
  next = nullptr;
  if (scans.size() == filter.limit) {
    scans.pop_back();
    next = scans.back().id;
  }
  return scans;
}

std::string ArchiveUrl(int id) { return "/scans/" + std::to_string(id) + ".zip"; }

}  // namespace

void Service::AddStoreMethods() {
  methods_.Add({"scan.list", Role::kRead, PageParameters(), RpcSchema({{"scans", "array"}, {"next", "integer"}}),
                "The scans, newest first; `next` goes on where it ended.",
                [this](const Json& params, Client&, const Reply& reply) {
                  Json scans = Json::array(), next;
                  for (const ScanSummary& scan : Page(store_, params, false, next)) scans.push_back(ScanJson(scan));
                  reply(Json{{"scans", std::move(scans)}, {"next", std::move(next)}});
                }});
  methods_.Add(
      {"object.list", Role::kRead, PageParameters(), RpcSchema({{"objects", "array"}, {"next", "integer"}}),
       "The objects that have a description, newest first.", [this](const Json& params, Client&, const Reply& reply) {
         Json objects = Json::array(), next;
         for (const ScanSummary& scan : Page(store_, params, true, next)) {
           objects.push_back(
               {{"scan", scan.id}, {"label", scan.label}, {"n_parts", scan.types.size()}, {"types", scan.types}});
         }
         reply(Json{{"objects", std::move(objects)}, {"next", std::move(next)}});
       }});
  methods_.Add({"scan.delete",
                Role::kAdmin,
                {ScanIdParameter(true)},
                RpcSchema({{"scan", "integer"}}),
                "Remove a scan and its files for good.",
                [this](const Json& params, Client&, const Reply& reply) {
                  const int id = ScanParameter(params, false);
                  if (job_ && job_->id == id)
                    throw RpcError(Code::kBusy, "the scan runs", "Cancel it first (scan.cancel)");
                  Discard(id);
                  reply(Json{{"scan", id}});
                }});
  methods_.Add({"scan.pin",
                Role::kScan,
                {ScanIdParameter(true), {"pinned", "boolean", "False: no longer", false, 0, 0, {}}},
                RpcSchema({{"scan", "integer"}, {"pinned", "boolean"}}),
                "Keep a scan whatever its age and the space it takes.",
                [this](const Json& params, Client&, const Reply& reply) {
                  const int id = ScanParameter(params, false);
                  const bool pinned = params.value("pinned", true);
                  store_.Pin(id, pinned);
                  reply(Json{{"scan", id}, {"pinned", pinned}});
                }});
  methods_.Add({"scan.export",
                Role::kRead,
                {ScanIdParameter(false)},
                RpcSchema({{"scan", "integer"}, {"path", "string"}, {"bytes", "integer"}}),
                "Pack a scan into a zip archive, to be fetched over HTTP (GET path); POST /scans takes one in.",
                [this](const Json& params, Client&, const Reply& reply) {
                  const int id = ScanParameter(params, false);
                  ExportScan(id, [id, reply](const std::variant<fs::path, RpcError>& made) {
                    if (const RpcError* error = std::get_if<RpcError>(&made)) {
                      reply(*error);
                      return;
                    }
                    std::error_code ignored;
                    reply(Json{{"scan", id},
                               {"path", ArchiveUrl(id)},
                               {"bytes", fs::file_size(std::get<fs::path>(made), ignored)}});
                  });
                }});
  methods_.Add({"store.status",
                Role::kRead,
                {},
                RpcSchema({{"scans", "integer"},
                           {"bytes", "integer"},
                           {"free_bytes", "integer"},
                           {"folder", "string"},
                           {"max_age_days", "integer"},
                           {"max_size_gb", "number"},
                           {"expired", "array"}}),
                "How much is stored, and which scans go next.",
                [this](const Json&, Client&, const Reply& reply) {
                  reply(Json{{"scans", store_.count()},
                             {"bytes", store_.bytes()},
                             {"free_bytes", store_.free_bytes()},
                             {"folder", (config_.folder / config_.store_folder).string()},
                             {"max_age_days", config_.store_max_age_days},
                             {"max_size_gb", config_.store_max_size_gb},
                             {"expired", store_.Expired(std::chrono::system_clock::now())}});
                }});
  methods_.Add({"log.tail",
                Role::kAdmin,
                {{"limit", "integer", "At most so many lines", false, 1, 1000, {}}},
                RpcSchema({{"lines", "array"}}),
                "The last lines of the log, oldest first.",
                [](const Json& params, Client&, const Reply& reply) {
                  reply(Json{{"lines", LogTail(params.value("limit", std::size_t{100}))}});
                }});
}

void Service::Discard(int id) {
  const fs::path left = store_.Discard(id);
  descriptions_.erase(id);
  grasps_.erase(id);
  compute_thread_.Post([left] {
    std::error_code ignored;  // what stays is removed when the store is opened again
    fs::remove_all(left, ignored);
  });
  Publish("scan", {{"scan", id}, {"state", "deleted"}});
}

void Service::ExportScan(int id, const PathReply& reply) {
  const ScanSummary scan = FindScan(id);
  if (job_ && job_->id == id) throw RpcError(Code::kBusy, "the scan runs", "Wait for its end");
  const fs::path archive = store_.ExportFile(id);
  std::error_code none;
  if (scan.state == ScanState::kDone && fs::exists(archive, none)) {
    fs::last_write_time(archive, fs::file_time_type::clock::now(), none);  // somebody still wants it
    reply(archive);
    return;
  }
  compute_thread_.Post([this, id, folder = store_.Folder(id), archive, reply] {
    std::exception_ptr failure;
    try {
      WriteScanArchive(folder, archive);
    } catch (...) {
      failure = std::current_exception();
    }
    OnIo([archive, reply, failure] {
      if (failure) {
        reply(ToRpcError(failure));
      } else {
        reply(archive);
      }
    });
  });
}

fs::path Service::ImportFile() {
  std::error_code error;
  fs::create_directories(store_.ImportFolder(), error);
  return store_.ImportFolder() / (std::to_string(++imports_) + ".zip");
}

void Service::ImportScan(const fs::path& archive, const Reply& reply) {
  fs::path folder = archive;
  folder.replace_extension();
  compute_thread_.Post([this, archive, folder, reply] {
    std::exception_ptr failure;
    try {
      ReadScanArchive(archive, folder);
    } catch (...) {
      failure = std::current_exception();
    }
    std::error_code ignored;
    fs::remove(archive, ignored);
    OnIo([this, folder, reply, failure] {
      try {
        if (failure) std::rethrow_exception(failure);
        const int id = store_.Adopt(folder);
        const ScanSummary scan = FindScan(id);
        Log(spdlog::level::info, {id, "", ""}, "scan " + std::to_string(id) + " was taken in from an archive");
        Publish("scan", {{"scan", id},
                         {"state", ScanStateName(scan.state)},
                         {"n_parts", scan.types.size()},
                         {"types", scan.types}});
        reply(ScanJson(scan));
      } catch (...) {
        reply(ToRpcError(std::current_exception()));
      }
    });
  });
}

void Service::KeepHouse(std::chrono::system_clock::time_point now, std::chrono::steady_clock::time_point steady_now) {
  const auto offset = now.time_since_epoch() -
                      std::chrono::duration_cast<std::chrono::system_clock::duration>(steady_now.time_since_epoch());
  const auto before = std::exchange(clock_offset_, offset);
  if (before && std::chrono::abs(offset - *before) > kClockStep) {
    const auto minutes = std::chrono::duration_cast<std::chrono::minutes>(offset - *before).count();
    spdlog::warn("the clock was set by {} minutes: no scan is removed for its age until it runs evenly", minutes);
    CountRefusal("clock_step");
    return;
  }
  try {
    for (const int id : store_.Expired(now)) {
      if (job_ && job_->id == id) continue;
      Discard(id);
      Log(spdlog::level::info, {id, "", ""},
          "scan " + std::to_string(id) + " is removed, as store.max_age_days or store.max_size_gb ask");
    }
    std::error_code none;
    const fs::path exports = store_.ExportFile(1).parent_path();
    std::vector<fs::path> unwanted;
    for (const fs::directory_entry& entry : fs::directory_iterator(exports, none)) {
      if (fs::file_time_type::clock::now() - entry.last_write_time(none) > kExportKept)
        unwanted.push_back(entry.path());
    }
    for (const fs::path& path : unwanted) fs::remove(path, none);
  } catch (const FileError& error) {
    spdlog::error("{}", error.what());
  }
}

}  // namespace geond::daemon
