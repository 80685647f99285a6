// SPDX-License-Identifier: Apache-2.0
// Makes a small sweep database (schema grtx.sweep/3, docs/guide/sweep.md) with SQLite itself. Times, areas and energies
// follow from the coordinates by the formulas below, so that a test knows them.
#pragma once

#include <sqlite3.h>

#include <map>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>

namespace grtx::testing_sweep {

inline void execute(const std::string& path, const std::string& sql) {
  sqlite3* database = nullptr;
  char* message = nullptr;
  int code = sqlite3_open(path.c_str(), &database);
  if (code == SQLITE_OK) code = sqlite3_exec(database, sql.c_str(), nullptr, nullptr, &message);
  const std::string reason = message == nullptr ? "cannot be opened" : message;
  sqlite3_free(message);
  sqlite3_close(database);
  if (code != SQLITE_OK) throw std::runtime_error(path + ": " + reason);
}

inline std::string quoted(const std::string& text) {
  std::string sql = "'";
  for (const char c : text) sql += c == '\'' ? std::string("''") : std::string(1, c);
  return sql + "'";
}

inline const char* const kSchema = R"(
CREATE TABLE meta(key TEXT PRIMARY KEY, value TEXT) STRICT;
CREATE TABLE trace(key TEXT PRIMARY KEY, scene TEXT, options TEXT, path TEXT, bytes INTEGER, status TEXT, reason TEXT,
                   seconds REAL) STRICT;
CREATE TABLE point(id INTEGER PRIMARY KEY, key TEXT UNIQUE NOT NULL, trace_key TEXT, machine TEXT, mode TEXT, scene TEXT,
                   design TEXT, coordinates TEXT, config TEXT, status TEXT, reason TEXT, seconds REAL, document TEXT) STRICT;
CREATE TABLE value(point_id INTEGER REFERENCES point(id), name TEXT, value REAL, PRIMARY KEY(point_id, name)) WITHOUT ROWID,
                   STRICT;
CREATE TABLE quantity(name TEXT PRIMARY KEY, unit TEXT, description TEXT) STRICT;
CREATE TABLE present(point_id INTEGER PRIMARY KEY REFERENCES point(id)) STRICT;
INSERT INTO meta VALUES ('schema', 'grtx.sweep/3'), ('plan', '[sweep]' || char(10) || 'kind = "grid"'),
                        ('program', 'grtx test'), ('created', '2026');
)";

/// Documents that say what the table `value` says.
inline void write_documents(const std::string& path) {
  sqlite3* database = nullptr;
  sqlite3_stmt* select = nullptr;
  std::map<int, nlohmann::json> documents;
  if (sqlite3_open(path.c_str(), &database) == SQLITE_OK &&
      sqlite3_prepare_v2(database, "SELECT point_id, name, value FROM value", -1, &select, nullptr) == SQLITE_OK) {
    while (sqlite3_step(select) == SQLITE_ROW) {
      const std::string name = reinterpret_cast<const char*>(sqlite3_column_text(select, 1));
      nlohmann::json& document = documents[sqlite3_column_int(select, 0)];
      const double value = sqlite3_column_double(select, 2);
      if (name.starts_with("cost.")) {
        document["cost"][name] = value;
      } else {
        document["stats"][name]["value"] = value;
      }
    }
  }
  sqlite3_finalize(select);
  sqlite3_close(database);
  std::string sql = "BEGIN;\n";
  for (const auto& [id, document] : documents) {
    sql += "UPDATE point SET document = " + quoted(document.dump()) + " WHERE id = " + std::to_string(id) + ";\n";
  }
  execute(path, sql + "COMMIT;\n");
}

/// 60 points: warp buffer 4, 8, 12, 16, 20 x checkpoint lanes 1, 4, 16 x L1 64 or 128 KiB x k 4 or 8; #7 failed and #31
/// timed out, 58 are done. config: resolved configuration of all points, as JSON text (warp buffer, lanes and L1 are
/// set in it). For warps w, lanes l, L1 b KiB and k: time = 1000 + 6000 / w + 300 / l + 20000 / b + 40 |k - 8| us, area
/// = 10 + 0.2 w
/// + 0.05 l + 0.02 b mm2, energy = 50 + time / 40 nJ per ray.
inline void make_grid(const std::string& path, const std::string& config) {
  execute(path, std::string(kSchema) + R"(
BEGIN;
INSERT INTO trace VALUES ('t4', 'pizza', '{"k": 4}', 'k4.grtx', 1000, 'done', NULL, 1.0),
                         ('t8', 'pizza', '{"k": 8}', 'k8.grtx', 2000, 'done', NULL, 1.0);
CREATE TEMP TABLE grid AS
WITH warps(w) AS (VALUES (4), (8), (12), (16), (20)), lanes(l) AS (VALUES (1), (4), (16)),
     bytes(b) AS (VALUES (64), (128)), buffers(k) AS (VALUES (4), (8))
SELECT row_number() OVER (ORDER BY w, l, b, k) AS id, w, l, b, k, 1000 + 6000.0 / w + 300.0 / l + 20000.0 / b + 40 * abs(k - 8) AS time,
       10 + 0.2 * w + 0.05 * l + 0.02 * b AS area
FROM warps, lanes, bytes, buffers;
INSERT INTO point SELECT id, printf('key%02d', id), 't' || k, 'paper', 'cycle', 'pizza', 'grtx',
  json_object('rt.warp_buffer.entries', w, 'rt.checkpoint.lanes', l, 'l1.bytes', b * 1024, 'k', k),
  json_set()" + quoted(config) +
                    R"(, '$."rt.warp_buffer.entries"', w, '$."rt.checkpoint.lanes"', l, '$."l1.bytes"', b * 1024),
  CASE id WHEN 7 THEN 'failed' WHEN 31 THEN 'timeout' ELSE 'done' END,
  CASE id WHEN 7 THEN 'watchdog: <no progress>' WHEN 31 THEN 'longer than 20 s' END, 1.5, '{}' FROM grid;
INSERT INTO present SELECT id FROM grid;
INSERT INTO value SELECT id, 'gpu.time_us', time FROM grid WHERE id NOT IN (7, 31);
INSERT INTO value SELECT id, 'gpu.cycles', round(time * 1365) FROM grid WHERE id NOT IN (7, 31);
INSERT INTO value SELECT id, 'cost.mm2', area FROM grid WHERE id NOT IN (7, 31);
INSERT INTO value SELECT id, 'cost.mm2_low', 0.6 * area FROM grid WHERE id NOT IN (7, 31);
INSERT INTO value SELECT id, 'cost.mm2_high', 1.8 * area FROM grid WHERE id NOT IN (7, 31);
INSERT INTO value SELECT id, 'gpu.energy_nj_per_ray', 50 + time / 40 FROM grid WHERE id NOT IN (7, 31);
INSERT INTO value SELECT id, 'gpu.l1.node.hit_rate', 0.5 + b / 512.0 FROM grid WHERE id NOT IN (7, 31);
INSERT INTO value SELECT id, 'gpu.dram.bytes', 1e9 / b FROM grid WHERE id NOT IN (7, 31);
INSERT INTO value SELECT id, 'gpu.rt.selections', time * 300 FROM grid WHERE id NOT IN (7, 31);
INSERT INTO value SELECT id, 'gpu.rt.stall.memory', time * 900 FROM grid WHERE id NOT IN (7, 31);
INSERT INTO value SELECT id, 'gpu.rt.stall.checkpoint', time * 165 / l FROM grid WHERE id NOT IN (7, 31);
INSERT INTO value SELECT id, 'gpu.energy_nj.rt', time * 100 FROM grid WHERE id NOT IN (7, 31);
INSERT INTO value SELECT id, 'gpu.energy_nj.dram', time * 220 FROM grid WHERE id NOT IN (7, 31);
COMMIT;
)");
  write_documents(path);
}

/// One point a row: {id, machine, mode, design, scene, coordinates, earlier_plan, values{}, status, reason}; missing
/// members have defaults.
inline void make_points(const std::string& path, const nlohmann::json& points) {
  std::string sql = std::string(kSchema) + "BEGIN;\n";
  for (const nlohmann::json& p : points) {
    const std::string id = std::to_string(p.at("id").get<int>());
    sql += "INSERT INTO point VALUES (" + id + ", 'key" + id + "', 't', " + quoted(p.value("machine", "paper")) + ", " +
           quoted(p.value("mode", "cycle")) + ", " + quoted(p.value("scene", "room")) + ", " +
           quoted(p.value("design", "grtx")) + ", " + quoted(p.value("coordinates", nlohmann::json::object()).dump()) +
           ", " + quoted(p.value("config", nlohmann::json::object()).dump()) + ", " +
           quoted(p.value("status", "done")) + ", " + quoted(p.value("reason", "")) + ", 1.0, '{}');\n";
    if (!p.value("earlier_plan", false)) sql += "INSERT INTO present VALUES (" + id + ");\n";
    const nlohmann::json values = p.value("values", nlohmann::json::object());
    for (const auto& [name, value] : values.items()) {
      sql += "INSERT INTO value VALUES (" + id + ", " + quoted(name) + ", " + value.dump() + ");\n";
    }
  }
  execute(path, sql + "COMMIT;\n");
  write_documents(path);
}

}  // namespace grtx::testing_sweep
