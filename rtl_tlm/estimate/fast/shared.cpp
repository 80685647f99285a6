#include "grtx/rtl_tlm/estimate/fast/shared.h"

#include "grtx/rtl_tlm/estimate/fast/fast_l1.h"
#include "grtx/rtl_tlm/gpu/gpu.h"

namespace grtx::sim::fast {
namespace {

std::uint32_t most_indices(const GpuConfig& config) {
  return std::max({config.rt.warp_buffer.entries * modules::kMaxLanes, config.resident(),
                   static_cast<unsigned>(L1::fills_of(config))});
}

}  // namespace

Shared::Shared(const GpuConfig& c, const traces::Header& h, std::uint64_t eviction_entries, unsigned events)
    : config(c),
      header(h),
      traffic(h, c.rt.memory.traffic),
      map(h, memory_map_config(c, h, eviction_entries)),
      stride(events),
      agenda(c.sms, most_indices(c)),
      memory(c, map.bytes()),
      selection(modules::make_warp_selection(c.rt.scheduler.policy)),
      drawn(c.fast.seed * 0xD1B54A32D192ED03u) {}

}  // namespace grtx::sim::fast
