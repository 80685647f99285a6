#include "grtx/rtl_tlm/memory/dram_simulators.h"

#include "grtx/base/error.h"

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

}  // namespace grtx::sim
