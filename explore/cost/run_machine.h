// SPDX-License-Identifier: Apache-2.0
// Which hardware units the machine of a run had, derived from the inputs of its trace.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "grtx/rtl_tlm/gpu/machine_use.h"

namespace grtx::explore {

/// inputs: "inputs" of a statistics document; entries at their defaults may be missing. where: file named in Error.
/// Throws Error for invalid values.
sim::MachineUse machine_of_run(const nlohmann::ordered_json& inputs, const std::string& where);

/// Sets only what a machine's tracer options decide, too: node layout and width, stack entries, where hits lie and
/// wait, and checkpoint lists.
void choose_nodes_and_lists(const nlohmann::ordered_json& inputs, const std::string& where, sim::MachineUse& use);

/// The same as options of `grtx cost`. All options are given, so that --machine cannot override any.
std::vector<std::string> cost_arguments(const sim::MachineUse& use);

}  // namespace grtx::explore
