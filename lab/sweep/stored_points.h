// The points of a sweep's database, each with what tells it from the others.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "grtx/lab/sweep/sqlite.h"
#include "grtx/rtl_tlm/run/result_notes.h"

namespace grtx::sim {

struct StoredPoint {
  std::int64_t id = 0;
  std::string key;
  std::string machine;  ///< its name; "" for none, and in a database that does not say it
  std::string mode, scene, design;
  /// What the plan varied at this point, and after tell_apart() whatever else it is made from that differs: name ->
  /// value. Also what is called a view: "view", "width", "height", "fov_scale".
  nlohmann::ordered_json coordinates;
  nlohmann::ordered_json config;                        ///< resolved; none while it waits
  std::shared_ptr<const nlohmann::ordered_json> trace;  ///< as trace_inputs() has it; none where it is unknown
  nlohmann::ordered_json inputs;                        ///< of the simulation; null without a document
  std::string status;                                   ///< pending, running, done, failed, killed or timeout
  std::string reason;
  ResultNotes notes;          ///< what limits the meaning of its values
  bool earlier_plan = false;  ///< the plan that filled the database last does not ask for it

  bool done() const { return status == "done"; }
};

/// A database's text as JSON; none is {}. Throws Error{path, place, rule} for what is no object.
nlohmann::ordered_json stored_object(const std::string& text, const std::string& path, const std::string& place);

/// What a trace is made from, SweepTrace::options, as name -> value: "width", "tracer.k". Without what its points have
/// from their design, and what follows from the rest.
nlohmann::ordered_json trace_inputs(const nlohmann::ordered_json& options);

/// Those that `wanted` takes by their keys, in the order of their ids. The database must have passed check_sweep().
/// Throws Error{database, point, rule} for what is no JSON object.
std::vector<StoredPoint> read_points(
    Sqlite& database, const std::function<bool(const std::string& key)>& wanted = [](const auto&) { return true; });

/// Adds to each point's coordinates what points of equal machine, mode, scene and design differ in, be it varied or set
/// by an edited plan: so no two of them are called the same. points: pointers, which may be to a derived type.
void tell_apart(const std::vector<StoredPoint*>& points);

}  // namespace grtx::sim
