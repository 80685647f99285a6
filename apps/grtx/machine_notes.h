// What the name of a machine says of a result: whether the trace is of this machine, and the mode was measured on it.
#pragma once

#include <string>

#include "grtx/rtl_tlm/gpu/mode_keys.h"
#include "grtx/rtl_tlm/run/result_notes.h"
#include "grtx/traces/header.h"

namespace grtx::sim {

/// Each option that a machine of the project, or this one, chooses, and that the trace has with another value than this
/// machine: one note, or none. None, too, for no machine (""), and for a trace that does not name its options.
ResultNotes tracer_notes(const std::string& machine, const traces::Header& header);

/// The same, and of an engine whose error was measured on some machines alone a note on every other.
ResultNotes machine_notes(const std::string& machine, SimulationMode engine, const traces::Header& header);

/// Puts these before the notes of a result, and of its document.
void put_first(ResultNotes notes, nlohmann::ordered_json& document);

}  // namespace grtx::sim
