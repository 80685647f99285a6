// SPDX-License-Identifier: Apache-2.0
// All that the simulator knows of a part of the RT unit: plain data that the part makes from its configuration.
// Energy, cost, lower bounds, idle keys, differences and reports go through the table of all parts (rt_unit_table.h)
// and know none of them by its name.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace grtx::modules {

/// An action does this once, or `times` times: it reads or writes a word of a memory, uses an operator, or takes a
/// pipeline through a test.
struct EnergyTerm {
  enum class Of : std::uint8_t { read, write, operation, test };
  Of of = Of::operation;
  std::string module;      ///< whose inventory has the memory or the pipelines: the end of its hierarchical name
  std::string item;        ///< the memory, or the operator
  unsigned width = 0;      ///< bits of the operator
  unsigned pipelines = 1;  ///< of the module, and how often each uses its operators in a test
  unsigned interval = 1;
  double times = 1.0;
};
inline EnergyTerm reads(const std::string& module, const std::string& memory, double times = 1.0) {
  return {EnergyTerm::Of::read, module, memory, 0, 1, 1, times};
}
inline EnergyTerm writes(const std::string& module, const std::string& memory, double times = 1.0) {
  return {EnergyTerm::Of::write, module, memory, 0, 1, 1, times};
}
inline EnergyTerm uses(const std::string& operation, unsigned width, double times = 1.0) {
  return {EnergyTerm::Of::operation, "", operation, width, 1, 1, times};
}

/// An action that a run counts, and what one of them costs.
struct EnergyAction {
  std::string name = {};                     ///< in reports of energy: rt.ray_box
  std::vector<std::string> statistics = {};  ///< their sum is the number of actions,
  double factor = 1.0;                       ///< times this
  std::vector<EnergyTerm> terms = {};
  std::string basis = {};       ///< what an action is: "node tests, sort included"
  bool off_by_default = false;  ///< a run may lack the statistics: the part counted nothing
};

/// A lower bound on the cycles of a run: the busiest RT unit did ceil(statistics / rate) cycles of work, less those in
/// which nothing waits after the last piece.
struct PartBound {
  /// The resource that is busy. In lists bounds of the issue stand first, with the SIMT core's, and those of ports to
  /// the L1 last.
  enum class Limit : std::uint8_t { issue, units, port };
  std::string name = {};                     ///< without the prefix gpu.bound.
  std::vector<std::string> statistics = {};  ///< of one RT unit; their sum is its work
  std::uint64_t rate = 1;                    ///< pieces of work a cycle
  std::uint64_t drain = 0;                   ///< cycles
  Limit limit = Limit::units;
  std::string description = {};
  std::string words = {};  ///< in sentences: "the ray-box units"
};

/// Keys without effect in this configuration.
struct PartIdleKeys {
  std::string key;      ///< a key, or the begin of several: ends in a dot
  std::string because;  ///< "rt.traversal = lane"
};

/// Why an RT unit waits for the part, as words of a sentence.
struct StallWords {
  std::string stall;  ///< a name of Stall
  std::string words;
};

/// Pipelines whose occupation observers show and whose latency the cost model checks.
struct PartPipelines {
  std::string count_key;  ///< rt.box.count
  unsigned latency = 0;   ///< as configured
  /// Operators of a test one after another, a register after each: add, mul, min_max, less.
  std::vector<std::string> critical_path;
};

struct PartInfo {
  std::string name;   ///< of its module below the RT unit: ray_box; its counters may have it, too: gpu.rt.ray_box.*
  std::string title;  ///< in lists of differences: "ray-box unit"; "": its statistics are listed with the scheduler's
  std::vector<std::string> statistics;  ///< prefixes of their names
  std::vector<std::string> keys;        ///< prefixes of their names
  std::vector<EnergyAction> energy;
  std::vector<PartBound> bounds;
  std::vector<PartIdleKeys> idle_keys;
  std::vector<StallWords> stalls;
  std::optional<PartPipelines> pipelines;
  /// Of a unit at the node port (node_port_if.h): its count of node sectors that it answered itself, so that the L1
  /// never saw them: "node_buffer.hits".
  std::string kept_nodes;
};

}  // namespace grtx::modules
