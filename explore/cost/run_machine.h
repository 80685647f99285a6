// Which units the machine of a run had: those that its trace needs.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "grtx/rtl_tlm/gpu/machine_use.h"

namespace grtx::sim {

/// inputs: of statistics, texts by name; what has its default may be missing. where: named in Error, which is thrown
/// for values that nothing has.
MachineUse machine_of_run(const nlohmann::ordered_json& inputs, const std::string& where);

/// That of them which says how a ray's checkpoint lists are kept; they may also be a machine's tracer options.
void choose_bins(const nlohmann::ordered_json& inputs, const std::string& where, MachineUse& use);

}  // namespace grtx::sim
