// SPDX-License-Identifier: Apache-2.0
// Notes on a result whose trace and machine do not belong together: other tracer options, or a design without its
// units.
#pragma once

#include <set>
#include <string>

#include "grtx/rtl_tlm/gpu/gpu_config.h"
#include "grtx/rtl_tlm/run/result_notes.h"
#include "grtx/traces/header.h"

namespace grtx::study {

/// At most one note, listing tracer options whose value in the trace differs from that of `machine`. Considers only
/// options set by this machine or any machine of the project. Empty if machine is "" or the trace does not record its
/// options.
sim::ResultNotes tracer_notes(const std::string& machine, const traces::Header& header);

/// At most one note: the trace was made with structure and tracer options of a design that has configuration keys of
/// its own, and `config` has other values of them. Keys in `named` are the user's. Any k may be the design's.
sim::ResultNotes design_notes(const traces::Header& header, const sim::GpuConfig& config,
                              const std::set<std::string>& named);

/// Inserts `notes` before the notes of a result's document.
void put_first(sim::ResultNotes notes, nlohmann::ordered_json& document);

}  // namespace grtx::study
