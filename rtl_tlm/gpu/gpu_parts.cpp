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

bool has_own_parts(GpuParts parts, const GpuConfig& config) {
  parts = with_registered_parts(std::move(parts), config);
  bool any = false;
  for_each_factory(parts, [&any](const char*, const auto& factory) { any = any || factory; });
  return any;
}

}  // namespace grtx::sim
