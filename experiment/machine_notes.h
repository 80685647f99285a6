// SPDX-License-Identifier: Apache-2.0
// A trace and a machine that do not belong together: notes on other tracer options and on a design without its units,
// and the refusal of a design that the trace is not of.
#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <string>

#include "grtx/explore/sweep/designs.h"
#include "grtx/rtl_tlm/gpu/gpu_config.h"
#include "grtx/rtl_tlm/run/result_notes.h"
#include "grtx/traces/header.h"

namespace grtx::experiment {

/// At most one note, listing tracer options whose value in the trace differs from `own`, those of `machine` and its
/// file, below those of `design` (null: none). Considers only options set by this machine or any machine of the
/// project. Empty if machine is "" or the trace does not record its options.
sim::ResultNotes tracer_notes(const std::string& machine, const std::map<std::string, std::string>& own,
                              const explore::Design* design, const traces::Header& header);

/// At most one note: the trace was made with structure and tracer options of a design that has configuration keys of
/// its own, and `config` has other values of them. Keys in `named` are the user's. Any k may be the design's.
sim::ResultNotes design_notes(const traces::Header& header, const sim::GpuConfig& config,
                              const std::set<std::string>& named);

/// Throws Error{file, place, rule} unless a trace is of the design: structure, checkpointing, traversal and layout. Any
/// k may be the design's, and its other options are the user's to change. inputs: as a trace's header or statistics
/// have them; where not given there, as the tracer does by default.
void check_design(const std::string& file, const std::string& place, const std::map<std::string, std::string>& inputs,
                  const explore::Design& design);
/// The same of a trace's header.
void check_design(const std::string& file, const traces::Header& header, const explore::Design& design);
/// Inputs of statistics for check_design(): those of the trace under its own names.
std::map<std::string, std::string> traced_inputs(const nlohmann::ordered_json& inputs);
/// Name of the design with configuration keys of its own that a trace is of, as check_design() has it; "" if none.
std::string design_with_units(const std::map<std::string, std::string>& inputs);

/// Inserts `notes` before the notes of a result's document.
void put_first(sim::ResultNotes notes, nlohmann::ordered_json& document);

}  // namespace grtx::experiment
