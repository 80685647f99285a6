#include "grtx/explore/sweep/database.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <ctime>

#include "grtx/base/error.h"
#include "grtx/base/json.h"
#include "grtx/explore/sweep/check_values.h"

namespace grtx::sim {
namespace {

using nlohmann::ordered_json;

constexpr const char* kTables = R"(
CREATE TABLE IF NOT EXISTS meta(key TEXT PRIMARY KEY, value TEXT){0};
CREATE TABLE IF NOT EXISTS trace(key TEXT PRIMARY KEY, scene TEXT, options TEXT, path TEXT, bytes INTEGER,
                                 status TEXT, reason TEXT, seconds REAL){0};
CREATE TABLE IF NOT EXISTS point(id INTEGER PRIMARY KEY, key TEXT UNIQUE NOT NULL, trace_key TEXT, mode TEXT,
                                 scene TEXT, design TEXT, coordinates TEXT, config TEXT, status TEXT, reason TEXT,
                                 seconds REAL, document TEXT){0};
CREATE TABLE IF NOT EXISTS value(point_id INTEGER REFERENCES point(id), name TEXT, value REAL,
                                 PRIMARY KEY(point_id, name)) WITHOUT ROWID{1};
CREATE TABLE IF NOT EXISTS quantity(name TEXT PRIMARY KEY, unit TEXT, description TEXT){0};
)";
constexpr const char* kSchemaName = "grtx.sweep/2";
constexpr const char* kOldSchemaName = "grtx.sweep/1";  // columns took whatever came; still read

/// strict: a column takes values of its type alone.
std::string tables(bool strict) { return fmt::format(kTables, strict ? " STRICT" : "", strict ? ", STRICT" : ""); }

std::string now_text() {
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  gmtime_r(&now, &utc);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &utc);
  return text;
}

/// The cost of one RT unit: sm0.rt, or the first of several.
const ordered_json* rt_unit(const ordered_json& node) {
  for (const ordered_json& sm : node.at("children")) {
    if (!sm.at("name").get<std::string>().starts_with("sm")) continue;
    for (const ordered_json& part : sm.at("children")) {
      if (part.at("name").get<std::string>().starts_with("rt")) return &part;
    }
  }
  return nullptr;
}

/// An entry of a database's schema.
struct SchemaObject {
  std::string type, sql;
};

/// By name, without SQLite's own.
std::map<std::string, SchemaObject> schema_of(Sqlite& database) {
  std::map<std::string, SchemaObject> objects;
  SqliteStatement select(database, "SELECT name, type, sql FROM sqlite_master");
  while (select.step()) {
    std::string sql = select.text(2);
    std::erase_if(sql, [](unsigned char c) { return std::isspace(c) != 0; });
    if (!select.text(0).starts_with("sqlite_")) objects[select.text(0)] = {select.text(1), sql};
  }
  return objects;
}

std::map<std::string, SchemaObject> expected_schema(bool strict) {
  Sqlite made;
  made.execute(tables(strict));
  return schema_of(made);
}

std::string schema_name(Sqlite& database) {
  SqliteStatement table(database, "SELECT count(*) FROM sqlite_master WHERE name = 'meta'");
  table.step();
  if (table.integer(0) == 0) return "";
  SqliteStatement select(database, "SELECT value FROM meta WHERE key = 'schema'");
  return select.step() ? select.text(0) : "";
}

/// strict: nothing besides a sweep's tables.
void check_schema(Sqlite& database, bool strict) {
  static const std::map<std::string, SchemaObject> now = expected_schema(true), before = expected_schema(false);
  const auto& expected = schema_name(database) == kOldSchemaName ? before : now;
  for (const auto& [name, object] : schema_of(database)) {
    const auto known = expected.find(name);
    if (known == expected.end() && !strict) continue;
    if (known != expected.end() && object.type == known->second.type && object.sql == known->second.sql) continue;
    throw Error(database.path(), object.type + " " + name,
                known != expected.end() ? "is not the table that a sweep makes"
                                        : "was not made by a sweep, and could change its results: drop it");
  }
}

/// What holds of all points, whichever came first: "largest lower bound: longest_ray" and "largest lower bound:
/// longest_warp" are both "largest lower bound".
std::string of_both(const std::string& a, const std::string& b) {
  if (a == b) return a;
  const auto end = std::mismatch(a.begin(), a.end(), b.begin(), b.end()).first;
  const std::string common(a.begin(), end);
  if (common == a || common == b) return common;
  return common.substr(0, common.rfind(": "));
}

}  // namespace

void check_sweep(const std::string& path) {
  Sqlite database(path, Sqlite::Open::read_only);
  check_schema(database, false);
  const std::string schema = schema_name(database);
  if (schema != kSchemaName && schema != kOldSchemaName) {
    throw Error(path, "meta.schema", std::string("must be ") + kSchemaName);
  }
  check_values(database, schema == kSchemaName);
}

std::vector<CostValue> cost_values(const ordered_json& cost) {
  const ordered_json& tree = cost.at("tree");
  const std::string at = fmt::format(" at {} nm", cost.at("technology").at("nm").get<int>());
  // Area and leakage go through logarithms, whose last bit differs between mathematical libraries.
  const auto area = [&](const ordered_json& node, const char* end) {
    return nine_digits(node.at("area_mm2").at(end).get<double>());
  };
  const ordered_json* unit = rt_unit(tree);
  const double bits = tree.at("flip_flop_bits").get<double>() + tree.at("memory_bits").get<double>();
  return {
      {"cost.mm2", "mm2", "area of the modelled part of the chip, central" + at, area(tree, "central")},
      {"cost.mm2_low", "mm2", "the same, low end of the band", area(tree, "low")},
      {"cost.mm2_high", "mm2", "the same, high end of the band", area(tree, "high")},
      {"cost.rt_unit_mm2", "mm2", "area of one RT unit, central" + at, unit == nullptr ? 0.0 : area(*unit, "central")},
      {"cost.storage_bits", "bits", "flip-flops and memories of the modelled part of the chip", bits},
      {"cost.leakage_mw", "mW", "leakage of the modelled part of the chip, central" + at,
       nine_digits(tree.at("leakage_mw").at("central").get<double>())},
      {"cost.checkpoint_bytes", "B", "storage that checkpointing adds to an RT unit (the paper's table)",
       cost.at("checkpoint_storage").at("bytes").get<double>()}};
}

SweepDatabase::SweepDatabase(const std::string& path) : database_(path, Sqlite::Open::create) {
  bool empty = true;
  {
    SqliteStatement tables(database_, "SELECT count(*) FROM sqlite_master");
    tables.step();
    empty = tables.integer(0) == 0;
  }
  if (empty) {
    SqliteTransaction transaction(database_);
    database_.execute(tables(true));
    set_meta("schema", kSchemaName);
    set_meta("created", now_text());
    transaction.commit();
  } else {
    const std::string schema = schema_name(database_);
    if (schema == kOldSchemaName) {
      throw Error(path, "meta.schema",
                  schema + ", of an earlier version, can be read by report and --compare, not filled: begin another");
    }
    if (schema != kSchemaName) throw Error(path, "meta.schema", std::string("must be ") + kSchemaName);
    check_schema(database_, true);
    check_values(database_, true);
  }
}

std::string SweepDatabase::meta(const std::string& key) {
  return text_of("SELECT value FROM meta WHERE key = ?1", key);
}

void SweepDatabase::set_meta(const std::string& key, const std::string& value) {
  SqliteStatement insert(database_, "INSERT OR REPLACE INTO meta VALUES(?1, ?2)");
  insert.bind(1, key).bind(2, value).run();
}

void SweepDatabase::begin(const std::string& plan, const std::string& program, const std::string& build, bool retry) {
  SqliteTransaction transaction(database_);
  set_meta("plan", plan);
  set_meta("program", program);
  if (meta("build").empty()) set_meta("build", build);
  const std::string again = retry ? "status IN ('running', 'failed', 'killed', 'timeout')" : "status = 'running'";
  for (const char* table : {"trace", "point"}) {
    database_.execute(fmt::format("UPDATE {} SET status = 'pending', reason = NULL WHERE {}", table, again));
  }
  transaction.commit();
}

void SweepDatabase::add(const SweepPoints& points) {
  SqliteTransaction transaction(database_);
  SqliteStatement trace(database_, "INSERT OR IGNORE INTO trace VALUES(?1, ?2, ?3, ?4, 0, 'pending', NULL, 0)");
  for (const auto& t : points.traces) {
    trace.bind(1, t->key)
        .bind(2, t->scene)
        .bind(3, json_text(t->options))
        .bind(4, "traces/" + trace_name(t->key))
        .run();
  }
  SqliteStatement point(
      database_,
      "INSERT OR IGNORE INTO point(key, trace_key, mode, scene, design, coordinates, status, seconds) "
      "VALUES(?1, ?2, ?3, ?4, ?5, ?6, 'pending', 0)");
  for (const SweepPoint& p : points.points) {
    point.bind(1, p.key).bind(2, p.trace_key).bind(3, p.mode).bind(4, p.scene).bind(5, p.design);
    point.bind(6, json_text(p.coordinates)).run();
  }
  transaction.commit();
}

std::string SweepDatabase::text_of(const char* sql, const std::string& key) {
  SqliteStatement select(database_, sql);
  return select.bind(1, key).step() ? select.text(0) : "";
}

std::vector<std::string> SweepDatabase::statuses_of(const std::vector<SweepPoint>& points) {
  SqliteStatement select(database_, "SELECT status FROM point WHERE key = ?1");
  std::vector<std::string> statuses;
  statuses.reserve(points.size());
  for (const SweepPoint& point : points) {
    statuses.push_back(select.bind(1, point.key).step() ? select.text(0) : "");
    select.reset();
  }
  return statuses;
}

std::string SweepDatabase::status_of_point(const std::string& key) {
  return text_of("SELECT status FROM point WHERE key = ?1", key);
}

std::string SweepDatabase::status_of_trace(const std::string& key) {
  return text_of("SELECT status FROM trace WHERE key = ?1", key);
}

std::string SweepDatabase::reason_of_point(const std::string& key) {
  return text_of("SELECT reason FROM point WHERE key = ?1", key);
}

std::string SweepDatabase::reason_of_trace(const std::string& key) {
  return text_of("SELECT reason FROM trace WHERE key = ?1", key);
}

double SweepDatabase::value(const std::string& key, const std::string& name) {
  SqliteStatement select(
      database_, "SELECT value.value FROM value JOIN point ON point.id = point_id WHERE key = ?1 AND name = ?2");
  if (!select.bind(1, key).bind(2, name).step()) throw Error(database_.path(), key, "has no value " + name);
  return select.real(0);
}

std::vector<std::string> SweepDatabase::value_names(const std::string& key) {
  SqliteStatement select(database_,
                         "SELECT name FROM value JOIN point ON point.id = point_id WHERE key = ?1 ORDER BY name");
  select.bind(1, key);
  std::vector<std::string> names;
  while (select.step()) names.push_back(select.text(0));
  return names;
}

void SweepDatabase::set_running(const std::vector<Task>& tasks) {
  SqliteTransaction transaction(database_);
  SqliteStatement trace(database_, "UPDATE trace SET status = 'running' WHERE key = ?1");
  SqliteStatement point(database_, "UPDATE point SET status = 'running', config = ?2 WHERE key = ?1");
  for (const Task& task : tasks) {
    if (task.is_trace) {
      trace.bind(1, task.key).run();
    } else {
      point.bind(1, task.key).bind(2, json_text(task.description.at("config"))).run();
    }
  }
  transaction.commit();
}

namespace {

/// All that `value` holds of a point: statistics, and what its machine costs.
ordered_json stored_document(const TaskOutcome& o) {
  ordered_json document = o.document;
  for (const CostValue& cost : cost_values(o.cost)) document["cost"][cost.name] = cost.value;
  return document;
}

}  // namespace

void SweepDatabase::record(const TaskOutcome& o) {
  SqliteTransaction transaction(database_);
  const bool done = o.status == "done";
  SqliteStatement update(database_, o.is_trace ? "UPDATE trace SET status = ?2, reason = nullif(?3, ''), "
                                                 "seconds = coalesce(nullif(?4, 0), seconds), bytes = ?5 WHERE key = ?1"
                                               : "UPDATE point SET status = ?2, reason = nullif(?3, ''), seconds = ?4, "
                                                 "document = nullif(?5, '') WHERE key = ?1");
  update.bind(1, o.key).bind(2, o.status).bind(3, o.reason).bind(4, o.seconds);
  if (o.is_trace) {
    update.bind(5, static_cast<std::int64_t>(o.bytes));
  } else {
    update.bind(5, done ? json_text(stored_document(o)) : std::string());
  }
  update.run();
  if (done && !o.is_trace) record_values(o.key, o);
  transaction.commit();
}

void SweepDatabase::record_values(const std::string& key, const TaskOutcome& o) {
  SqliteStatement select(database_, "SELECT id FROM point WHERE key = ?1");
  if (!select.bind(1, key).step()) return;
  const std::int64_t id = select.integer(0);
  select.reset();
  SqliteStatement value(database_, "INSERT OR REPLACE INTO value VALUES(?1, ?2, ?3)");
  SqliteStatement known(database_, "SELECT description FROM quantity WHERE name = ?1");
  SqliteStatement quantity(database_, "INSERT OR REPLACE INTO quantity VALUES(?1, ?2, ?3)");
  const auto add = [&](const std::string& name, double number, const std::string& unit, const std::string& text) {
    value.bind(1, id).bind(2, name).bind(3, number).run();
    const std::string description = known.bind(1, name).step() ? of_both(known.text(0), text) : text;
    known.reset();
    quantity.bind(1, name).bind(2, unit).bind(3, description).run();
  };
  for (const auto& [name, statistic] : o.document.at("stats").items()) {
    if (!statistic.at("value").is_number()) continue;
    add(name, statistic.at("value").get<double>(), statistic.value("unit", ""), statistic.value("description", ""));
  }
  for (const CostValue& cost : cost_values(o.cost)) add(cost.name, cost.value, cost.unit, cost.description);
}

void SweepDatabase::refuse(const std::vector<Refusal>& refusals) {
  SqliteTransaction transaction(database_);
  SqliteStatement update(database_,
                         "UPDATE point SET status = 'failed', reason = nullif(?2, ''), seconds = 0, document = NULL, "
                         "config = ?3 WHERE key = ?1");
  for (const auto& [point, reason] : refusals) {
    update.bind(1, point->key).bind(2, reason).bind(3, point->config.text()).run();
  }
  transaction.commit();
}

std::map<std::string, std::size_t> SweepDatabase::summary(const std::vector<SweepPoint>& points) {
  std::map<std::string, std::size_t> counts;
  for (const std::string& status : statuses_of(points)) ++counts[status];
  return counts;
}

}  // namespace grtx::sim
