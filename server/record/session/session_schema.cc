#include "server/record/session/session_schema.h"

#include <stdexcept>

#include <SQLiteCpp/Statement.h>
#include <sqlite3.h>
#include <nlohmann/json.hpp>

namespace mwidth::record {
namespace {

constexpr const char* kTables = R"(
CREATE TABLE info(key TEXT PRIMARY KEY, value) WITHOUT ROWID;
CREATE TABLE blocks(number INTEGER PRIMARY KEY, first_tick INTEGER NOT NULL, last_tick INTEGER NOT NULL,
                    samples INTEGER NOT NULL, checksum INTEGER NOT NULL, data BLOB NOT NULL);
CREATE TABLE tail(number INTEGER PRIMARY KEY, first_tick INTEGER NOT NULL, last_tick INTEGER NOT NULL,
                  samples INTEGER NOT NULL, checksum INTEGER NOT NULL, data BLOB NOT NULL);
CREATE TABLE events(id INTEGER PRIMARY KEY, number INTEGER NOT NULL, kind INTEGER NOT NULL,
                    tick INTEGER NOT NULL, monotonic_ns INTEGER NOT NULL, message TEXT NOT NULL,
                    metadata TEXT NOT NULL);
CREATE TABLE markers(number INTEGER PRIMARY KEY, label TEXT NOT NULL, kind TEXT NOT NULL,
                     metadata TEXT NOT NULL, monotonic_ns INTEGER NOT NULL, error_ns INTEGER NOT NULL,
                     arrival_ns INTEGER NOT NULL, client_ns INTEGER NOT NULL);
CREATE TABLE gaps(id INTEGER PRIMARY KEY, after_tick INTEGER NOT NULL, before_tick INTEGER NOT NULL,
                  missed_ticks INTEGER NOT NULL, lost_ticks INTEGER NOT NULL, reason TEXT NOT NULL);
CREATE TABLE wall_clock_steps(id INTEGER PRIMARY KEY, monotonic_ns INTEGER NOT NULL,
                              offset_ns INTEGER NOT NULL);
)";

class InfoRows {
 public:
  explicit InfoRows(SQLite::Database& database)
      : insert_(database, "INSERT OR REPLACE INTO info VALUES(?, ?)") {}

  template <typename Value>
  void Put(const char* key, const Value& value) {
    insert_.reset();
    insert_.bind(1, key);
    insert_.bind(2, value);
    insert_.exec();
  }

 private:
  SQLite::Statement insert_;
};

class InfoReader {
 public:
  explicit InfoReader(SQLite::Database& database)
      : select_(database, "SELECT value FROM info WHERE key = ?") {}

  std::string Text(const char* key) { return Column(key, SQLITE_TEXT).getString(); }
  int64_t Integer(const char* key) { return Column(key, SQLITE_INTEGER).getInt64(); }
  double Real(const char* key) { return Column(key, SQLITE_FLOAT).getDouble(); }
  bool Has(const char* key) {
    Find(key);
    return select_.hasRow();
  }

 private:
  void Find(const char* key) {
    select_.reset();
    select_.bind(1, key);
    select_.executeStep();
  }
  SQLite::Column Column(const char* key, int type) {
    Find(key);
    if (!select_.hasRow() || select_.getColumn(0).getType() != type) {
      throw std::runtime_error(std::string("its table info has no ") + key + ", or not of the right type");
    }
    return select_.getColumn(0);
  }

  SQLite::Statement select_;
};

SessionLabels ReadLabels(InfoReader& info) {
  return {.subject = info.Text("subject"),
          .visit = info.Text("visit"),
          .task = info.Text("task"),
          .run = static_cast<int>(info.Integer("run")),
          .operator_name = info.Text("operator"),
          .metadata = MetadataOf(info.Text("metadata"))};
}

SessionAxis ReadAxis(InfoReader& info) {
  return {.name = info.Text("axis"),
          .rotary = info.Integer("rotary") != 0,
          .period_s = info.Real("period_s"),
          .position_quantum = info.Real("position_quantum"),
          .force_quantum = info.Real("force_quantum"),
          .acceleration_quantum = info.Real("acceleration_quantum"),
          .force_limit = info.Real("force_limit"),
          .force_slew_limit = info.Real("force_slew_limit")};
}

SessionState StateOf(int64_t number) {
  if (number < 0 || number > static_cast<int64_t>(SessionState::kRecovered)) {
    throw std::runtime_error("its state " + std::to_string(number) + " is none of this format");
  }
  return static_cast<SessionState>(number);
}

}  // namespace

void CountSamples(SQLite::Database& database, SessionInfo& info) {
  SQLite::Statement count(
      database,
      "SELECT sum(samples), min(first_tick), max(last_tick) FROM (SELECT samples, first_tick, "
      "last_tick FROM blocks UNION ALL SELECT samples, first_tick, last_tick FROM tail)");
  count.executeStep();
  info.sample_count = static_cast<uint64_t>(count.getColumn(0).getInt64());
  info.first_tick = static_cast<uint64_t>(count.getColumn(1).getInt64());
  info.last_tick = static_cast<uint64_t>(count.getColumn(2).getInt64());
}

void CreateTables(SQLite::Database& database) {
  database.exec("PRAGMA application_id = " + std::to_string(kSessionApplicationId));
  database.exec("PRAGMA user_version = " + std::to_string(kSessionFormat));
  database.exec(kTables);
}

void WriteInfo(const SessionInfo& info, SQLite::Database& database) {
  InfoRows rows(database);
  rows.Put("subject", info.labels.subject);
  rows.Put("visit", info.labels.visit);
  rows.Put("task", info.labels.task);
  rows.Put("run", info.labels.run);
  rows.Put("operator", info.labels.operator_name);
  rows.Put("metadata", MetadataText(info.labels.metadata));
  rows.Put("axis", info.axis.name);
  rows.Put("rotary", info.axis.rotary ? 1 : 0);
  rows.Put("period_s", info.axis.period_s);
  rows.Put("position_quantum", info.axis.position_quantum);
  rows.Put("force_quantum", info.axis.force_quantum);
  rows.Put("acceleration_quantum", info.axis.acceleration_quantum);
  rows.Put("force_limit", info.axis.force_limit);
  rows.Put("force_slew_limit", info.axis.force_slew_limit);
  rows.Put("software_version", info.provenance.software_version);
  rows.Put("configuration", info.provenance.configuration);
  rows.Put("command_line", info.provenance.command_line);
  rows.Put("axis_state", info.provenance.axis_state);
  rows.Put("state", static_cast<int>(info.state));
  rows.Put("start_wall_ns", info.start_wall_ns);
  rows.Put("start_monotonic_ns", info.start_monotonic_ns);
  if (info.end_wall_ns) {
    rows.Put("end_wall_ns", *info.end_wall_ns);
  } else {
    database.exec("DELETE FROM info WHERE key = 'end_wall_ns'");
  }
}

SessionInfo ReadInfo(SQLite::Database& database) {
  InfoReader rows(database);
  SessionInfo info;
  info.labels = ReadLabels(rows);
  info.axis = ReadAxis(rows);
  info.provenance = {.software_version = rows.Text("software_version"),
                     .configuration = rows.Text("configuration"),
                     .command_line = rows.Text("command_line"),
                     .axis_state = rows.Text("axis_state")};
  info.state = StateOf(rows.Integer("state"));
  info.start_wall_ns = rows.Integer("start_wall_ns");
  info.start_monotonic_ns = rows.Integer("start_monotonic_ns");
  if (rows.Has("end_wall_ns")) {
    info.end_wall_ns = rows.Integer("end_wall_ns");
  }
  return info;
}

std::string MetadataText(const std::map<std::string, std::string>& metadata) {
  return nlohmann::json(metadata).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

std::map<std::string, std::string> MetadataOf(const std::string& text) {
  std::map<std::string, std::string> metadata;
  const auto json = nlohmann::json::parse(text, nullptr, false);
  if (json.is_object()) {
    for (const auto& [key, value] : json.items()) {
      if (value.is_string()) {
        metadata.emplace(key, value.get<std::string>());
      }
    }
  }
  return metadata;
}

}  // namespace mwidth::record
