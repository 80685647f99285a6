// SPDX-License-Identifier: Apache-2.0
// Energy of a run: each action counted by the simulation times its energy, plus leakage over the run time.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "grtx/explore/cost/cost_tree.h"
#include "grtx/modules/kernel/inventory.h"
#include "grtx/rtl_tlm/gpu/gpu_config.h"

namespace grtx::explore {

struct EnergyOptions {
  double dram_pj_per_bit = 7.5;  ///< GDDR6 (Micron, average device power); GDDR6X 7.25, HBM2E 6.0
  double wire_mm = 10.0;         ///< path length of a packet in the crossbar; judgement: half the edge of a small die
  double wire_fj_per_bit_mm_40nm = 240;  ///< at 40 nm; 115 at 10 nm (Keckler 2011, Dally 2020): interpolated
};

struct EnergyPart {
  std::string name;    ///< e.g. rt.ray_box, l1, dram, leakage
  double actions = 0;  ///< number of actions
  Range nanojoules;
  std::string basis;  ///< meaning of an action
};

/// Returns the value of a run's statistic, by name (docs of `grtx sim`); nullopt if the run does not have it.
using RunStatistics = std::function<std::optional<double>(const std::string& name)>;

/// Computes the energy of a run by part, each in whole picojoules. inventories: of the machine that ran. Order and
/// names of the parts are the same for every run, except the part `own`. statistics: name of the statistics in
/// messages. Throws Error{statistics, name, rule} if a required counter is missing; only gpu.dram.* may be missing
/// (external memory models), and then costs nothing.
std::vector<EnergyPart> run_energy(const RunStatistics& value, const sim::GpuConfig& config,
                                   const std::vector<modules::Inventory>& inventories, const CostOptions& options,
                                   const EnergyOptions& energy, const std::string& statistics = "statistics");

Range total(const std::vector<EnergyPart>& parts);

}  // namespace grtx::explore
