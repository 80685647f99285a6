// SPDX-License-Identifier: Apache-2.0
#include "grtx/rtl_tlm/memory/dram_simulators.h"

#include "grtx/base/error.h"
#include "grtx/rtl_tlm/gpu/gpu_config.h"
#include "grtx/rtl_tlm/memory/ported_memory.h"

#ifdef GRTX_WITH_DRAMSYS
#include "grtx/rtl_tlm/memory/dramsys_dram.h"
#endif
#ifdef GRTX_WITH_RAMULATOR
#include "grtx/rtl_tlm/memory/ramulator_dram.h"
#endif

namespace grtx::sim {

std::vector<std::string> dram_simulators() {
  std::vector<std::string> names;
#ifdef GRTX_WITH_DRAMSYS
  names.emplace_back("dramsys");
#endif
#ifdef GRTX_WITH_RAMULATOR
  names.emplace_back("ramulator");
#endif
  return names;
}

std::unique_ptr<PortedDram> build_dram_simulator(const std::string& simulator, [[maybe_unused]] const char* module,
                                                 [[maybe_unused]] const PortedDramConfig& config) {
#ifdef GRTX_WITH_DRAMSYS
  if (simulator == "dramsys") return std::make_unique<DramsysDram>(module, config);
#endif
#ifdef GRTX_WITH_RAMULATOR
  if (simulator == "ramulator") return std::make_unique<RamulatorDram>(module, config);
#endif
  throw Error("configuration", "dram.model", "this program was built without '" + simulator + "'");
}

void register_dram_simulators() {
  static bool done = false;
  if (done) return;
  done = true;
  for (const std::string& name : dram_simulators()) {
    const auto build = [name](const PortedDramConfig& config) { return build_dram_simulator(name, "dram", config); };
    register_memory_system(
        name, [name, build](Gpu& gpu, const BuildOptions&) { return std::make_unique<PortedMemory>(name, build, gpu); },
        true);
  }
}

}  // namespace grtx::sim
