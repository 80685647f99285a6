// Which units the machine of a run had: those that its trace needs.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "grtx/rtl_tlm/gpu/machine_use.h"

namespace grtx::sim {

/// inputs: of statistics, texts by name; what has its default may be missing. where: named in Error, which is thrown
/// for values that nothing has.
MachineUse machine_of_run(const nlohmann::ordered_json& inputs, const std::string& where);

}  // namespace grtx::sim
