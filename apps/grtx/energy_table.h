// SPDX-License-Identifier: Apache-2.0
// The energy by part of every design and machine in results.json, as one table.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "grtx/explore/cost/cost_tree.h"
#include "grtx/explore/cost/run_energy.h"

namespace grtx::apps {

/// [{machine, design, parts, frames, run_nanojoules, frame_nanojoules}], from parts on as in grtx.energy/1. path: of
/// results.json. machine: the only one, by name or file; "" for all. Throws Error.
nlohmann::ordered_json energies_of(const nlohmann::ordered_json& results, const std::string& path,
                                   const std::string& machine, const explore::CostOptions& cost,
                                   const explore::EnergyOptions& energy);

/// For each machine a table of parts by designs, the central estimates in µJ.
std::string energies_text(const nlohmann::ordered_json& runs);
/// A row for each machine, design and part.
std::string energies_csv(const nlohmann::ordered_json& runs);

}  // namespace grtx::apps
