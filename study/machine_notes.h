// SPDX-License-Identifier: Apache-2.0
// Notes on a result whose trace was not made with the tracer options of its machine.
#pragma once

#include <string>

#include "grtx/rtl_tlm/run/result_notes.h"
#include "grtx/traces/header.h"

namespace grtx::study {

/// At most one note, listing tracer options whose value in the trace differs from that of `machine`. Considers only
/// options set by this machine or any machine of the project. Empty if machine is "" or the trace does not record its
/// options.
sim::ResultNotes tracer_notes(const std::string& machine, const traces::Header& header);

/// Inserts `notes` before the notes of a result's document.
void put_first(sim::ResultNotes notes, nlohmann::ordered_json& document);

}  // namespace grtx::study
