// What the name of a machine says of a result: whether the trace is of this machine.
#pragma once

#include <string>

#include "grtx/rtl_tlm/run/result_notes.h"
#include "grtx/traces/header.h"

namespace grtx::sim {

/// Each option that a machine of the project, or this one, chooses, and that the trace has with another value than this
/// machine: one note, or none. None, too, for no machine (""), and for a trace that does not name its options.
ResultNotes tracer_notes(const std::string& machine, const traces::Header& header);

/// Puts these before the notes of a result, and of its document.
void put_first(ResultNotes notes, nlohmann::ordered_json& document);

}  // namespace grtx::sim
