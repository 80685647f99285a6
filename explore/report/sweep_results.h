// A sweep database (schema grtx.sweep/2, docs/guide/sweep.md) as a report needs it.
#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "grtx/rtl_tlm/run/result_notes.h"

namespace grtx::sim {

struct ReportedPoint {
  std::int64_t id = 0;
  std::string key;
  std::string machine;  ///< its name; "" for none, and in a database that does not say it
  std::string mode;
  std::string scene;
  std::string design;
  nlohmann::ordered_json coordinates;  ///< what the plan varied at this point: name -> value
  nlohmann::ordered_json config;       ///< resolved
  nlohmann::ordered_json inputs;       ///< of the simulation; null without a document
  std::string status;                  ///< pending, running, done, failed, killed or timeout
  std::string reason;
  ResultNotes notes;                     ///< what limits the meaning of its values
  std::map<std::string, double> values;  ///< statistics and cost.*, by name

  bool done() const { return status == "done"; }
  /// NaN when there is no such value.
  double value(const std::string& name) const;
};

struct ReportedTrace {
  std::string key, scene, options, status, reason;
  std::uint64_t bytes = 0;
};

struct SweepResults {
  std::string file;                         ///< without its folder
  std::string hash;                         ///< XXH3 of keys, states and documents in the order of the keys
  std::map<std::string, std::string> meta;  ///< schema, plan, program, ...
  nlohmann::ordered_json search;            ///< grtx.search/1, null when no search filled the database
  std::vector<ReportedPoint> points;        ///< by id
  std::vector<ReportedTrace> traces;        ///< by key
  std::vector<std::string> coordinates;     ///< names of all coordinates, in order of appearance

  /// More than one scene, design, or mode among the points.
  bool several(std::string ReportedPoint::*field) const;
};

/// Whether the file begins like an SQLite database.
bool is_database(const std::string& path);
/// Throws Error when the file is no sweep database.
SweepResults read_sweep_results(const std::string& path);

}  // namespace grtx::sim
