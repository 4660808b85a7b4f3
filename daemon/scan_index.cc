// SPDX-License-Identifier: Apache-2.0
#include "daemon/scan_index.h"

#include <spdlog/spdlog.h>
#include <sqlite3.h>
#include <nlohmann/json.hpp>

#include "core/base/error.h"

namespace geond::daemon {
namespace {

constexpr int kVersion = 1;  // of the table; a file of another one is made anew
constexpr char kTable[] =
    "CREATE TABLE IF NOT EXISTS scans(id INTEGER PRIMARY KEY AUTOINCREMENT, state TEXT NOT NULL, views INTEGER NOT "
    "NULL,"
    " views_taken INTEGER NOT NULL, first_angle REAL NOT NULL, label TEXT NOT NULL, error TEXT NOT NULL,"
    " types TEXT NOT NULL, ended INTEGER NOT NULL, bytes INTEGER NOT NULL, pinned INTEGER NOT NULL);"
    "CREATE INDEX IF NOT EXISTS by_state ON scans(state, id);"
    "PRAGMA user_version = 1";
constexpr char kColumns[] = "id, state, views, views_taken, first_angle, label, error, types, ended, bytes, pinned";

[[noreturn]] void Fail(sqlite3* database, const std::string& path, const char* call) {
  const int code = database ? sqlite3_errcode(database) : SQLITE_NOMEM;
  const char* remedy = code == SQLITE_FULL       ? "Make room on the disk: delete or export old scans"
                       : code == SQLITE_READONLY ? "The disk is read-only: check it and mount it again"
                       : code == SQLITE_CORRUPT || code == SQLITE_NOTADB ? "Restart geond: it makes the index anew"
                                                                         : "Check the disk";
  throw FileError(path, call, database ? sqlite3_errmsg(database) : "out of memory", remedy);
}

// A statement that is let go whatever happens.
class Statement {
 public:
  Statement(sqlite3* database, const std::string& path, const std::string& text) : database_(database), path_(path) {
    if (sqlite3_prepare_v2(database, text.c_str(), -1, &statement_, nullptr) != SQLITE_OK)
      Fail(database, path, "read index");
  }
  ~Statement() { sqlite3_finalize(statement_); }
  Statement(const Statement&) = delete;
  Statement& operator=(const Statement&) = delete;

  Statement& Bind(std::int64_t value) {
    sqlite3_bind_int64(statement_, ++bound_, value);
    return *this;
  }
  Statement& Bind(double value) {
    sqlite3_bind_double(statement_, ++bound_, value);
    return *this;
  }
  Statement& Bind(std::string_view value) {
    sqlite3_bind_text(statement_, ++bound_, value.data(), static_cast<int>(value.size()), SQLITE_TRANSIENT);
    return *this;
  }
  // Whether there is a row.
  bool Step() {
    const int result = sqlite3_step(statement_);
    if (result != SQLITE_ROW && result != SQLITE_DONE) Fail(database_, path_, "use index");
    return result == SQLITE_ROW;
  }
  std::int64_t Whole(int column) const { return sqlite3_column_int64(statement_, column); }
  double Real(int column) const { return sqlite3_column_double(statement_, column); }
  std::string Text(int column) const {
    const unsigned char* text = sqlite3_column_text(statement_, column);
    return text ? reinterpret_cast<const char*>(text) : "";
  }

 private:
  sqlite3* database_;
  const std::string& path_;
  sqlite3_stmt* statement_ = nullptr;
  int bound_ = 0;
};

ScanState StateFromName(const std::string& name) {
  for (const ScanState state : {ScanState::kRunning, ScanState::kFailed, ScanState::kCancelled, ScanState::kDone}) {
    if (ScanStateName(state) == name) return state;
  }
  return ScanState::kInterrupted;
}

ScanSummary Row(const Statement& row) {
  ScanSummary scan;
  scan.id = static_cast<int>(row.Whole(0));
  scan.state = StateFromName(row.Text(1));
  scan.views = static_cast<int>(row.Whole(2));
  scan.views_taken = static_cast<int>(row.Whole(3));
  scan.first_angle = row.Real(4);
  scan.label = row.Text(5);
  scan.error = row.Text(6);
  const nlohmann::json types = nlohmann::json::parse(row.Text(7), nullptr, false);
  if (types.is_array()) {
    for (const nlohmann::json& type : types) scan.types.push_back(type.is_string() ? type.get<std::string>() : "");
  }
  scan.ended = std::chrono::system_clock::time_point(std::chrono::seconds(row.Whole(8)));
  scan.bytes = static_cast<std::uint64_t>(row.Whole(9));
  scan.pinned = row.Whole(10) != 0;
  return scan;
}

}  // namespace

ScanIndex::ScanIndex(const std::filesystem::path& path) : path_(path.string()) {
  if (Open(path_)) return;
  const int code = database_ ? sqlite3_errcode(database_) : SQLITE_NOMEM;
  const std::string cause = database_ ? sqlite3_errmsg(database_) : "out of memory";
  Close();
  std::error_code unremoved;
  for (const char* ending : {"", "-wal", "-shm"}) std::filesystem::remove(path_ + ending, unremoved);
  if (!unremoved && Open(path_)) {
    spdlog::warn("{} could not be used ({}) and is made anew from the scans", path_, cause);
    return;
  }
  Close();
  spdlog::warn("{} cannot be written ({}): the index is kept in memory", path_,
               code == SQLITE_OK ? "wrong version" : cause);
  durable_ = false;
  if (!Open(":memory:")) Fail(database_, path_, "open index");
}

ScanIndex::~ScanIndex() { Close(); }

void ScanIndex::Close() {
  sqlite3_close(database_);
  database_ = nullptr;
}

// False if the file is none of ours, broken or not to be written; why is the connection's last error.
bool ScanIndex::Open(const std::string& path) {
  const auto run = [this](const char* text) {
    return sqlite3_exec(database_, text, nullptr, nullptr, nullptr) == SQLITE_OK;
  };
  if (sqlite3_open(path.c_str(), &database_) != SQLITE_OK) return false;
  sqlite3_busy_timeout(database_, 2000);
  if (!run("PRAGMA locking_mode = EXCLUSIVE") || !run("PRAGMA journal_mode = WAL") || !run("PRAGMA synchronous = FULL"))
    return false;
  try {
    Statement check(database_, path_, "PRAGMA quick_check(1)");
    if (!check.Step() || check.Text(0) != "ok") return false;
    Statement version(database_, path_, "PRAGMA user_version");
    const std::int64_t found = version.Step() ? version.Whole(0) : -1;
    if (found != 0 && found != kVersion) return false;
  } catch (const FileError&) {
    return false;
  }
  // A change of nothing, to learn whether it can be written at all.
  return run(kTable) && run("BEGIN IMMEDIATE; DELETE FROM scans WHERE id < 0; COMMIT");
}

void ScanIndex::Put(const ScanSummary& scan) {
  const auto ended = std::chrono::duration_cast<std::chrono::seconds>(scan.ended.time_since_epoch()).count();
  Statement(database_, path_,
            std::string("INSERT OR REPLACE INTO scans(") + kColumns + ") VALUES(?,?,?,?,?,?,?,?,?,?,?)")
      .Bind(std::int64_t{scan.id})
      .Bind(ScanStateName(scan.state))
      .Bind(std::int64_t{scan.views})
      .Bind(std::int64_t{scan.views_taken})
      .Bind(scan.first_angle)
      .Bind(scan.label)
      .Bind(scan.error)
      .Bind(nlohmann::json(scan.types).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace))
      .Bind(std::int64_t{ended})
      .Bind(static_cast<std::int64_t>(scan.bytes))
      .Bind(std::int64_t{scan.pinned})
      .Step();
}

void ScanIndex::Remove(int id) {
  Statement(database_, path_, "DELETE FROM scans WHERE id = ?").Bind(std::int64_t{id}).Step();
}

void ScanIndex::BeginChanges() { Statement(database_, path_, "BEGIN IMMEDIATE").Step(); }

void ScanIndex::EndChanges() { Statement(database_, path_, "COMMIT").Step(); }

std::optional<ScanSummary> ScanIndex::Find(int id) const {
  Statement found(database_, path_, std::string("SELECT ") + kColumns + " FROM scans WHERE id = ?");
  if (!found.Bind(std::int64_t{id}).Step()) return std::nullopt;
  return Row(found);
}

std::vector<ScanSummary> ScanIndex::List(const ScanFilter& filter) const {
  Statement row(database_, path_,
                std::string("SELECT ") + kColumns + " FROM scans WHERE (?1 = 0 OR id < ?1)" +
                    (filter.done ? " AND state = 'done'" : "") + " ORDER BY id DESC LIMIT ?2");
  row.Bind(std::int64_t{filter.before}).Bind(static_cast<std::int64_t>(filter.limit));
  std::vector<ScanSummary> scans;
  while (row.Step()) scans.push_back(Row(row));
  return scans;
}

std::vector<ScanSummary> ScanIndex::Removable() const {
  Statement row(database_, path_,
                "SELECT id, ended, bytes FROM scans WHERE pinned = 0 AND state <> 'running' ORDER BY id");
  std::vector<ScanSummary> scans;
  while (row.Step()) {
    ScanSummary& scan = scans.emplace_back();
    scan.id = static_cast<int>(row.Whole(0));
    scan.ended = std::chrono::system_clock::time_point(std::chrono::seconds(row.Whole(1)));
    scan.bytes = static_cast<std::uint64_t>(row.Whole(2));
  }
  return scans;
}

std::int64_t ScanIndex::Number(const char* question) const {
  Statement row(database_, path_, question);
  return row.Step() ? row.Whole(0) : 0;
}

int ScanIndex::Newest(bool done) const {
  return static_cast<int>(
      Number(done ? "SELECT max(id) FROM scans WHERE state = 'done'" : "SELECT max(id) FROM scans"));
}

int ScanIndex::GreatestEver() const {
  return static_cast<int>(Number("SELECT seq FROM sqlite_sequence WHERE name = 'scans'"));
}

int ScanIndex::count() const { return static_cast<int>(Number("SELECT count(*) FROM scans")); }

std::uint64_t ScanIndex::bytes() const { return static_cast<std::uint64_t>(Number("SELECT sum(bytes) FROM scans")); }

}  // namespace geond::daemon
