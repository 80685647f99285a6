// SPDX-License-Identifier: Apache-2.0
#include "grtx/rtl_tlm/gpu/simulation_mode.h"

#include <fmt/format.h>

#include "grtx/base/error.h"
#include "grtx/base/json.h"

namespace grtx::sim {

std::string gone_mode(const std::string& name) {
  if (name != "fast" && name != "sampled") return "";
  return fmt::format("mode '{}' is gone: use cycle; of whole frames, windows", name);
}

Unmodelled unmodelled(const GpuConfig& config, SimulationMode mode) {
  if (mode == SimulationMode::cycle) return {};
  const nlohmann::ordered_json keys = config_json(config);
  for (const char* key : {"rt.checkpoint.implementation", "rt.box.implementation", "rt.transform.implementation"}) {
    if (keys.at(key) == "tlm") continue;
    return {key, "must be tlm with --mode windows: RTL is compared on whole traces"};
  }
  if (config.dram_model != kBuiltInMemory) {
    return {"dram.model", "must be built_in with --mode windows: the windows' intervals were tried with it"};
  }
  return {};
}

void check_mode(const GpuConfig& config, SimulationMode mode) {
  if (const Unmodelled lack = unmodelled(config, mode)) throw Error("configuration", lack.key, lack.rule);
}

}  // namespace grtx::sim
