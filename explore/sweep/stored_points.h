// SPDX-License-Identifier: Apache-2.0
// The points of a sweep's database, with the coordinates that distinguish them.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "grtx/explore/sweep/sqlite.h"
#include "grtx/rtl_tlm/run/result_notes.h"

namespace grtx::explore {

struct StoredPoint {
  std::int64_t id = 0;
  std::string key;
  std::string machine;  ///< name; "" for none
  std::string mode, scene, design;
  /// Varied parameters of this point, name -> value; after add_distinguishing_inputs() also all other inputs that
  /// differ between points. May include the view: "view", "width", "height", "fov_scale".
  nlohmann::ordered_json coordinates;
  nlohmann::ordered_json config;                        ///< resolved; empty while pending
  std::shared_ptr<const nlohmann::ordered_json> trace;  ///< trace_inputs(); null if unknown
  nlohmann::ordered_json inputs;                        ///< inputs of the simulation; null without a document
  std::string status;                                   ///< pending, running, done, failed, killed or timeout
  std::string reason;
  sim::ResultNotes notes;     ///< limitations of its values
  bool earlier_plan = false;  ///< not in the plan that filled the database last

  bool done() const { return status == "done"; }
};

/// Parses a JSON object stored in the database; "" gives {}. Throws Error{path, place, rule} if it is no object.
nlohmann::ordered_json stored_object(const std::string& text, const std::string& path, const std::string& place);

/// Flattens SweepTrace::options to name -> value: "width", "tracer.k". Leaves out accel and checkpoint (given by the
/// design) and trace_format (follows from the others).
nlohmann::ordered_json trace_inputs(const nlohmann::ordered_json& options);

/// Reads the points whose key `wanted` accepts, ordered by id. The database must have passed check_sweep(). Throws
/// Error{database, point, rule} if a stored text is no JSON object.
std::vector<StoredPoint> read_points(
    Sqlite& database, const std::function<bool(const std::string& key)>& wanted = [](const auto&) { return true; });

/// Adds to the coordinates all inputs in which points of equal machine, mode, scene and design differ, including
/// settings of an edited plan, so that no two points have the same name.
void add_distinguishing_inputs(const std::vector<StoredPoint*>& points);

}  // namespace grtx::explore
