// Energy of a run: the actions that a simulation counted, each times its price, and leakage over the time.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "grtx/lab/cost/cost_tree.h"
#include "grtx/modules/kernel/inventory.h"
#include "grtx/rtl_tlm/gpu/gpu_config.h"

namespace grtx::sim {

struct EnergyOptions {
  double dram_pj_per_bit = 7.5;          ///< GDDR6 (Micron, average device power); GDDR6X 7.25, HBM2E 6.0
  double wire_mm = 10.0;                 ///< way of a packet through the crossbar, a judgement: half a small die's edge
  double wire_fj_per_bit_mm_40nm = 240;  ///< at 40 nm; 115 at 10 nm (Keckler 2011, Dally 2020): scaled in between
};

struct EnergyPart {
  std::string name;    ///< e.g. rt.ray_box, l1, dram, leakage
  double actions = 0;  ///< how many were counted
  Range nanojoules;
  std::string basis;  ///< what an action is
};

/// A number that a run counted, by its name (docs of `grtx sim`); none when it is not among its statistics.
using RunStatistics = std::function<std::optional<double>(const std::string& name)>;

/// The one place that prices a run. inventories: of the same machine. Every part is in whole picojoules. Order and
/// names of the parts do not depend on the run, but for `own`. Throws Error{statistics, name, rule} for a count that a
/// run must have and this one has not; a memory that is not ours may have no gpu.dram.*, which then costs nothing.
/// statistics: what to call them.
std::vector<EnergyPart> run_energy(const RunStatistics& value, const GpuConfig& config,
                                   const std::vector<modules::Inventory>& inventories, const CostOptions& options,
                                   const EnergyOptions& energy, const std::string& statistics = "statistics");

Range total(const std::vector<EnergyPart>& parts);

}  // namespace grtx::sim
