// SPDX-License-Identifier: Apache-2.0
#include "grtx/rtl_tlm/gpu/simulation_mode.h"

#include <fmt/format.h>

namespace grtx::sim {

std::string gone_mode(const std::string& name) {
  if (name != "fast" && name != "sampled") return "";
  return fmt::format("mode '{}' is gone: use cycle; of whole frames, windows", name);
}

}  // namespace grtx::sim
