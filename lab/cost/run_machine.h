// Which units the machine of a run had: those that its trace needs.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "grtx/rtl_tlm/gpu/machine_use.h"

namespace grtx::sim {

/// inputs: of statistics, texts by name; what has its default may be missing. where: named in Error, which is thrown
/// for values that nothing has.
MachineUse machine_of_run(const nlohmann::ordered_json& inputs, const std::string& where);

/// Those of them that a machine's tracer options say, too: nodes, stack entries and how checkpoint lists are kept.
void choose_nodes_and_lists(const nlohmann::ordered_json& inputs, const std::string& where, MachineUse& use);

/// The same as options of `grtx cost`, all of them: a machine that is named there chooses nothing.
std::vector<std::string> cost_arguments(const MachineUse& use);

}  // namespace grtx::sim
