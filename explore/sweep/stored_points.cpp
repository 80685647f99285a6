// SPDX-License-Identifier: Apache-2.0
#include "grtx/explore/sweep/stored_points.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <map>

#include "grtx/base/error.h"
#include "grtx/base/json.h"
#include "grtx/explore/sweep/axis.h"
#include "grtx/explore/sweep/designs.h"
#include "grtx/explore/sweep/schema.h"

namespace grtx::explore {
namespace {

using nlohmann::ordered_json;

/// Converts "8" to 8: options of a trace are stored as text, values of an axis are typed.
ordered_json value_of(const ordered_json& option) {
  if (!option.is_string() || option.get_ref<const std::string&>().empty()) return option;
  const auto& text = option.get_ref<const std::string&>();
  const char *const begin = text.data(), *const end = begin + text.size();
  std::int64_t whole = 0;
  if (std::from_chars(begin, end, whole).ptr == end) return whole;
  double real = 0.0;
  if (std::from_chars(begin, end, real).ptr == end) return real;
  return option;
}

/// Collects names whose values differ, in the order found.
class Differences {
 public:
  /// Adds names whose values differ in two objects, or that only one of them has.
  void compare(const ordered_json& a, const ordered_json& b) {
    if (a == b) return;
    auto beside = b.begin();  // fast path: usually both have the same names in the same order
    for (const auto& [name, value] : a.items()) {
      if (beside == b.end() || beside.key() != name) beside = b.find(name);
      if (beside == b.end() || *beside != value) add(name);
      if (beside != b.end()) ++beside;
    }
    for (const auto& [name, value] : b.items()) {
      if (!a.contains(name)) add(name);
    }
  }
  const std::vector<std::string>& names() const { return names_; }

 private:
  void add(const std::string& name) {
    if (std::find(names_.begin(), names_.end(), name) == names_.end()) names_.push_back(name);
  }
  std::vector<std::string> names_;
};

constexpr const char* kMemoryFiles = "memory.files_hash";

/// Memory inputs not in the configuration: the hash of the memory model's configuration files.
ordered_json memory_inputs(const StoredPoint& point) {
  ordered_json inputs = ordered_json::object();
  if (point.inputs.is_object() && point.inputs.contains(kMemoryFiles)) {
    inputs[kMemoryFiles] = point.inputs.at(kMemoryFiles);
  }
  return inputs;
}

/// The configuration of a point whose design keeps hits in registers, less what the design itself sets for its k: as
/// many registers as k needs are no other machine.
ordered_json less_own_keys(const StoredPoint& point, const Design& design, unsigned k) {
  ordered_json config = point.config;
  for (const auto& [key, value] : keys_for(design, k)) {
    if (const auto found = config.find(key); found != config.end() && text_of(*found) == value) config.erase(found);
  }
  return config;
}

/// Design of a point whose keys follow its k; null for others, and where k is not known.
const Design* design_with_heaps(const StoredPoint& point) {
  const auto found = std::ranges::find(designs(), point.design, &Design::name);
  const bool heaps = found != designs().end() && found->registers_per_hit != 0;
  return heaps && point.trace != nullptr && point.trace->contains("tracer.k") ? &*found : nullptr;
}

void compare_configs(const StoredPoint& a, const StoredPoint& b, Differences& differences) {
  const Design *of_a = design_with_heaps(a), *of_b = design_with_heaps(b);
  if (of_a == nullptr || of_b == nullptr || a.trace->at("tracer.k") == b.trace->at("tracer.k")) {
    differences.compare(a.config, b.config);
    return;
  }
  const auto less = [](const StoredPoint& point, const Design& design) {
    return less_own_keys(point, design, k_of(design, text_of(point.trace->at("tracer.k"))));
  };
  differences.compare(less(a, *of_a), less(b, *of_b));
}

void fill(StoredPoint& point, const std::vector<std::string>& names) {
  const ordered_json memory = memory_inputs(point);
  const ordered_json* const known[] = {point.trace.get(), &point.config, &memory};
  for (const std::string& name : names) {
    if (point.coordinates.contains(name)) continue;
    for (const ordered_json* inputs : known) {
      if (inputs == nullptr || !inputs->is_object()) continue;
      if (const auto found = inputs->find(name); found != inputs->end()) {
        point.coordinates[name] = *found;
        break;
      }
    }
  }
}

}  // namespace

ordered_json stored_object(const std::string& text, const std::string& path, const std::string& place) {
  const ordered_json json = parse_json(text.empty() ? "{}" : text, path, place);
  if (!json.is_object()) throw Error(path, place, "must be a JSON object");
  return json;
}

ordered_json trace_inputs(const ordered_json& options) {
  ordered_json inputs = ordered_json::object();
  for (const auto& [name, value] : options.items()) {
    if (name == "trace_format") continue;  // follows from the options and the program
    if (name != "tracer") {
      inputs[name] = value;
      continue;
    }
    for (const auto& [option, text] : value.items()) {
      if (option != "accel" && option != "checkpoint") inputs["tracer." + option] = value_of(text);
    }
  }
  return inputs;
}

std::vector<StoredPoint> read_points(Sqlite& database, const std::function<bool(const std::string&)>& wanted) {
  const std::string& path = database.path();
  std::map<std::string, std::shared_ptr<const ordered_json>> traces;
  SqliteStatement trace(database, "SELECT key, options FROM trace");
  while (trace.step()) {
    const ordered_json options = stored_object(trace.text(1), path, "trace " + trace.text(0) + ": options");
    traces[trace.text(0)] = std::make_shared<const ordered_json>(trace_inputs(options));
  }
  std::vector<StoredPoint> points;
  SqliteStatement row(database,
                      "SELECT id, key, trace_key, machine, mode, scene, design, coordinates, config, status, reason, "
                      "earlier_plan, json_extract(document, '$.inputs'), json_extract(document, '$.notes') FROM " +
                          std::string(kSweepPoints) + " ORDER BY id");
  while (row.step()) {
    if (!wanted(row.text(1))) continue;
    StoredPoint& point = points.emplace_back();
    point.id = row.integer(0);
    const std::string where = fmt::format("point {}", point.id);
    point.key = row.text(1);
    if (const auto found = traces.find(row.text(2)); found != traces.end()) point.trace = found->second;
    point.machine = row.text(3);
    point.mode = row.text(4);
    point.scene = row.text(5);
    point.design = row.text(6);
    point.coordinates = stored_object(row.text(7), path, where + ": coordinates");
    point.config = stored_object(row.text(8), path, where + ": config");
    point.status = row.text(9);
    point.reason = row.text(10);
    point.earlier_plan = row.integer(11) != 0;
    if (!row.null(12)) point.inputs = stored_object(row.text(12), path, where + ": inputs");
    if (!row.null(13))
      point.notes = sim::notes_from(parse_json(row.text(13), path, where + ": notes"), path + ": " + where);
  }
  return points;
}

void add_distinguishing_inputs(const std::vector<StoredPoint*>& points) {
  // The first point of a group with a known trace, and with a known configuration.
  struct First {
    const StoredPoint* traced = nullptr;
    const StoredPoint* configured = nullptr;
  };
  std::map<std::vector<std::string>, First> groups;
  Differences differences;
  for (const StoredPoint* point : points) {
    First& first = groups[{point->machine, point->mode, point->scene, point->design}];
    if (first.traced == nullptr && point->trace != nullptr) first.traced = point;
    if (point->trace != nullptr && point->trace != first.traced->trace) {
      differences.compare(*point->trace, *first.traced->trace);
    }
    if (point->config.empty()) continue;
    if (first.configured == nullptr) first.configured = point;
    compare_configs(*point, *first.configured, differences);
    differences.compare(memory_inputs(*point), memory_inputs(*first.configured));
  }
  for (StoredPoint* point : points) fill(*point, differences.names());
}

}  // namespace grtx::explore
