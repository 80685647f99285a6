// SPDX-License-Identifier: Apache-2.0
#include "grtx/explore/sweep/database.h"

#include <fmt/format.h>

#include <algorithm>
#include <ctime>
#include <string_view>
#include <utility>

#include "grtx/base/error.h"
#include "grtx/base/json.h"
#include "grtx/explore/sweep/check_values.h"
#include "grtx/explore/sweep/schema.h"

namespace grtx::explore {
namespace {

using nlohmann::ordered_json;

constexpr std::string_view kUnfinished = "status IN ('failed', 'killed', 'timeout')";

std::string now_text() {
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  gmtime_r(&now, &utc);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &utc);
  return text;
}

/// Cost node of the first RT unit: sm0.rt; nullptr if there is none.
const ordered_json* rt_unit(const ordered_json& node) {
  for (const ordered_json& sm : node.at("children")) {
    if (!sm.at("name").get<std::string>().starts_with("sm")) continue;
    for (const ordered_json& part : sm.at("children")) {
      if (part.at("name").get<std::string>().starts_with("rt")) return &part;
    }
  }
  return nullptr;
}

/// The common part of two descriptions of one statistic: "largest lower bound: longest_ray" and "largest lower bound:
/// longest_warp" give "largest lower bound". Does not depend on the order of points.
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
  check_values(database);
}

std::vector<CostValue> cost_values(const ordered_json& cost) {
  const ordered_json& tree = cost.at("tree");
  const std::string at = fmt::format(" at {} nm", cost.at("technology").at("nm").get<int>());
  // Area and leakage are rounded: the last bit of logarithms differs between mathematical libraries.
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
    database_.execute(kSweepTables);
    set_meta("schema", kSweepSchema);
    set_meta("created", now_text());
    transaction.commit();
    return;
  }
  check_schema(database_, true);
  check_values(database_);
}

std::string SweepDatabase::meta(const std::string& key) {
  return text_of("SELECT value FROM meta WHERE key = ?1", key);
}

void SweepDatabase::set_meta(const std::string& key, const std::string& value) {
  SqliteStatement insert(database_, "INSERT OR REPLACE INTO meta VALUES(?1, ?2)");
  insert.bind(1, key).bind(2, value).run();
}

void SweepDatabase::begin(const SweepPlan& plan, const std::string& program, const std::string& build, bool retry) {
  SqliteTransaction transaction(database_);
  set_meta("plan", plan.text);
  std::string machines;
  for (const auto& [text, machine] : plan.machines) machines += (machines.empty() ? "" : ", ") + machine.name;
  set_meta("machine", machines.empty() ? plan.machine.name : machines);
  set_meta("area", plan.area);
  set_meta("program", program);
  if (meta("build").empty()) set_meta("build", build);
  database_.execute("UPDATE point SET status = 'pending', reason = NULL WHERE status = 'running'");
  database_.execute(std::string("UPDATE trace SET status = 'pending', reason = NULL WHERE status = 'running'") +
                    (retry ? " OR " + std::string(kUnfinished) : ""));
  transaction.commit();
  program_ = program;
  retry_ = retry;
  begun_ = true;
}

void SweepDatabase::add(const SweepPoints& points) {
  SqliteTransaction transaction(database_);
  if (std::exchange(begun_, false)) {
    database_.execute("DELETE FROM present; DELETE FROM meta WHERE key = 'search'");
  }
  SqliteStatement trace(database_,
                        "INSERT INTO trace VALUES(?1, ?2, ?3, ?4, 0, 'pending', NULL, 0) "
                        "ON CONFLICT(key) DO UPDATE SET scene = excluded.scene");
  for (const auto& t : points.traces) {
    trace.bind(1, t->key)
        .bind(2, t->scene)
        .bind(3, json_text(t->options))
        .bind(4, "traces/" + trace_name(t->key))
        .run();
  }
  // Each point is retried at most once per session.
  SqliteStatement retried(database_, fmt::format("UPDATE point SET status = 'pending', reason = NULL WHERE key = ?1 "
                                                 "AND {} AND id NOT IN (SELECT point_id FROM present)",
                                                 kUnfinished));
  // Known points take scene name and coordinates from this plan.
  SqliteStatement point(
      database_,
      "INSERT INTO point(key, trace_key, machine, mode, scene, design, coordinates, status, seconds) "
      "VALUES(?1, ?2, ?3, ?4, ?5, ?6, ?7, 'pending', 0) ON CONFLICT(key) DO UPDATE SET scene = excluded.scene, "
      "coordinates = excluded.coordinates WHERE scene IS NOT excluded.scene OR coordinates IS NOT "
      "excluded.coordinates");
  SqliteStatement elsewhere(database_, "UPDATE point SET scene = ?2, coordinates = ?3 WHERE key = ?1");
  SqliteStatement present(database_, "INSERT OR IGNORE INTO present SELECT id FROM point WHERE key = ?1");
  const std::vector<std::string> known_modes = modes();
  for (const SweepPoint& p : points.points) {
    const std::string coordinates = json_text(p.coordinates);
    if (retry_) retried.bind(1, p.key).run();
    point.bind(1, p.key).bind(2, p.trace_key).bind(3, p.machine).bind(4, p.mode).bind(5, p.scene).bind(6, p.design);
    point.bind(7, coordinates).run();
    present.bind(1, p.key).run();
    for (const std::string& mode : known_modes) {
      if (mode == p.mode) continue;
      const std::string key = key_in_mode(p, mode, program_);
      elsewhere.bind(1, key).bind(2, p.scene).bind(3, coordinates).run();
      present.bind(1, key).run();
    }
  }
  transaction.commit();
}

std::vector<std::string> SweepDatabase::modes() {
  SqliteStatement select(database_, "SELECT DISTINCT mode FROM point ORDER BY mode");
  std::vector<std::string> modes;
  while (select.step()) modes.push_back(select.text(0));
  return modes;
}

std::size_t SweepDatabase::earlier_points() {
  SqliteStatement select(database_, "SELECT count(*) FROM point WHERE id NOT IN (SELECT point_id FROM present)");
  select.step();
  return static_cast<std::size_t>(select.integer(0));
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

/// Document of a finished point: statistics plus cost.* of its machine.
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

std::map<std::string, std::size_t> SweepDatabase::reasons(const std::vector<SweepPoint>& points) {
  std::map<std::string, std::size_t> counts;
  for (const SweepPoint& point : points) {
    const std::string reason =
        text_of("SELECT reason FROM point WHERE key = ?1 AND status <> 'done' AND reason <> ''", point.key);
    if (!reason.empty()) ++counts[reason];
  }
  return counts;
}

}  // namespace grtx::explore
