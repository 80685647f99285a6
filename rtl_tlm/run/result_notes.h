// SPDX-License-Identifier: Apache-2.0
// Caveats on a run's figures. Decided here, kept with the result as "notes", and printed on stderr.
#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "grtx/modules/kernel/declare.h"
#include "grtx/rtl_tlm/gpu/gpu_config.h"
#include "grtx/traces/header.h"

namespace grtx::sim {

/// A launch of which a larger share is tail (no warp takes the place of one that has ended) gets a note.
inline constexpr double kMostTail = 0.5;

/// docs/model/statistics.md explains each id.
struct ResultNote {
  std::string id;    ///< for scripts, as "no-hits"
  std::string text;  ///< for people, one line
  bool operator==(const ResultNote&) const = default;
};
using ResultNotes = std::vector<ResultNote>;

/// Notes that depend on the trace only.
ResultNotes trace_notes(const traces::Header& header, const traces::Totals& totals);

/// Notes on a run of `groups` groups. statistics: of the run.
ResultNotes run_notes(const GpuConfig& config, const traces::Header& header, std::uint64_t groups,
                      const modules::StatisticList& statistics);

/// [{"id": "no-hits", "text": "..."}]
nlohmann::ordered_json notes_json(const ResultNotes& notes);
/// Reads such a list. Throws Error{path, "notes", rule} for anything else.
ResultNotes notes_from(const nlohmann::ordered_json& json, const std::string& path);

/// Prints each distinct note once on stderr, with the designs that have it. by_design: key "sim", "hw", ...
void print_notes(const std::map<std::string, ResultNotes>& by_design);

}  // namespace grtx::sim
