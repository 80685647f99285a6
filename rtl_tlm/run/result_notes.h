// What limits the meaning of a run's figures. Decided here, kept with the result as "notes", and said on stderr.
#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "grtx/modules/kernel/declare.h"
#include "grtx/rtl_tlm/gpu/gpu_config.h"
#include "grtx/traces/header.h"

namespace grtx::sim {

/// Each id and what it says: docs/model/statistics.md.
struct ResultNote {
  std::string id;    ///< for scripts, as "no-hits"
  std::string text;  ///< for people, one line
  bool operator==(const ResultNote&) const = default;
};
using ResultNotes = std::vector<ResultNote>;

/// Of what a trace holds, whatever runs it.
ResultNotes trace_notes(const traces::Header& header, const traces::Totals& totals);

/// Of what a machine made of so many groups: statistics are those of the run.
ResultNotes run_notes(const GpuConfig& config, const traces::Header& header, std::uint64_t groups,
                      const modules::StatisticList& statistics);

/// [{"id": "no-hits", "text": "..."}]
nlohmann::ordered_json notes_json(const ResultNotes& notes);
/// Throws Error{path, "notes", rule} for what is no such list.
ResultNotes notes_from(const nlohmann::ordered_json& json, const std::string& path);

/// A line on stderr for each note that is not an earlier one's. by_design: whose they are ("sim", "hw").
void print_notes(const std::map<std::string, ResultNotes>& by_design);

}  // namespace grtx::sim
