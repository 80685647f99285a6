#include "grtx/rtl_tlm/estimate/fast/fast_sm.h"

namespace grtx::sim::fast {
namespace {

LaneMask lowest(unsigned bits) { return bits >= 64 ? ~LaneMask{0} : modules::bit(bits) - 1; }

}  // namespace

// An MSHR holds a sector; they are reserved in turn, so a few more lines than that may be on their way.
std::size_t Sm::fills_of(const GpuConfig& config) { return std::size_t{2} * config.l1.mshr_entries + 64; }

Sm::Sm(const GpuConfig& config, const traces::Header& header, const modules::MemoryMap& map, unsigned index,
       traces::NodeKind leaf_kind)
    : program(header, map, config.simt.costs, index, config.resident_warps),
      issue(config.simt.schedulers, config.simt.instruction_latency),
      warps(config.resident_warps),
      free_slots(lowest(config.resident_warps)),
      calls(config.rt.warp_buffer.entries),
      ages(config.rt.warp_buffer.entries),
      free_entries(lowest(config.rt.warp_buffer.entries)),
      link(config.sm_links.l1_capacity),
      box(config.rt.ray_box),
      leaf(leaf_kind == traces::NodeKind::triangle ? config.rt.ray_triangle : config.rt.ray_sphere),
      transform(config.rt.ray_transform),
      hand_over(config.rt.checkpoint.lanes),
      tags(config.l1.geometry),
      sectors(config.l1.geometry.sectors()),
      largest(std::max(1u, config.l1.mshr_entries / 8)),  // a request waits for one MSHR and takes one a sector
      fills(fills_of(config)),
      filling(fills.size()),
      crossed(config.l1.miss_queue + config.links.capacity),
      mshrs(config.l1.mshr_entries),
      hits(config.l1.latency),
      banks(config.l1.banks) {
  rt.units = 1;
  for (auto i = static_cast<std::uint32_t>(fills.size()); i > 0; --i) free_fills.push_back(i - 1);
}

}  // namespace grtx::sim::fast
