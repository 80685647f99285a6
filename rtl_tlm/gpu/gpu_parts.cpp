// SPDX-License-Identifier: Apache-2.0
#include "grtx/rtl_tlm/gpu/gpu_parts.h"

#include <utility>

namespace grtx::sim {
namespace {

std::vector<PartsOfMachine>& registered() {
  static std::vector<PartsOfMachine> all;
  return all;
}

}  // namespace

void register_parts(PartsOfMachine parts) { registered().push_back(std::move(parts)); }

GpuParts with_registered_parts(GpuParts parts, const GpuConfig& config) {
  for (const PartsOfMachine& add : registered()) add(config, parts);
  return parts;
}

}  // namespace grtx::sim
