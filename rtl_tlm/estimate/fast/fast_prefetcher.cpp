#include "grtx/rtl_tlm/estimate/fast/fast_prefetcher.h"

#include <bit>

namespace grtx::sim::fast {

using namespace modules;
using traces::NodeKind;

Prefetcher::Prefetcher(Shared& shared, L1& l1)
    : shared_(shared),
      l1_(l1),
      siblings_(shared.config.rt.sibling_prefetch),
      records_(std::size_t{shared.config.rt.warp_buffer.entries} * kMaxLanes, shared.config.rt.prefetcher.records,
               shared.config.rt.names_siblings_in_entries(shared.header), shared.traffic),
      stacks_(std::size_t{shared.config.rt.warp_buffer.entries} * kMaxLanes, shared.config.rt.prefetcher.stack,
              shared.traffic) {}

void Prefetcher::prefetch(Cycle now, const traces::RayGroup& group, const Siblings& siblings) {
  ++counters_.triggers;
  if (siblings.replayed) ++counters_.replayed;
  const bool idle = l1_.idle(kPrefetch);
  const unsigned fresh = requests_.fresh(siblings);
  counters_.merged += static_cast<unsigned>(std::popcount(siblings.mask & ~fresh));
  records_.for_each_child(group.nodes[siblings.definition], fresh, [&](NodeKind kind, std::uint32_t child) {
    if (push(kind, shared_.traffic.address(child), counters_.merged, counters_.dropped)) ++counters_.nodes;
  });
  if (idle) l1_.serve(now);
}

void Prefetcher::note_entry(Cycle now, NodeKind kind, std::uint64_t address) {
  const bool idle = l1_.idle(kPrefetch);
  if (push(kind, address, counters_.entry_merged, counters_.entry_dropped)) ++counters_.entry_nodes;
  if (idle) l1_.serve(now);
}

void Prefetcher::warm_entry(NodeKind kind, std::uint64_t address) {
  const SectorRun run = shared_.traffic.run(kind, address);
  l1_.for_each_line(run, l1_.sectors(), [&](std::uint64_t line, std::uint8_t sectors) {
    l1_.warm(kPrefetch, line, sectors, run.region, false);
  });
}

void Prefetcher::note_stack(Cycle now, std::uint32_t lane, std::size_t left, std::uint32_t on_chip) {
  const bool idle = l1_.idle(kPrefetch);
  const bool looked = stacks_.moved(lane, left, on_chip, [&](const StackPrefetch::Node& node) {
    const std::uint64_t dropped = counters_.stack_dropped;
    if (push(node.kind, node.address, counters_.stack_merged, counters_.stack_dropped)) {
      ++counters_.stack_nodes;
      if (node.culled) ++counters_.stack_culled;
    }
    return counters_.stack_dropped == dropped;
  });
  if (!looked) return;
  ++counters_.stack_looks;
  if (idle) l1_.serve(now);
}

void Prefetcher::warm_stack(std::uint32_t lane, std::size_t left, std::uint32_t on_chip) {
  stacks_.moved(lane, left, on_chip, [&](const StackPrefetch::Node& node) {
    warm_entry(node.kind, node.address);
    return true;
  });
}

bool Prefetcher::push(NodeKind kind, std::uint64_t address, std::uint64_t& merged, std::uint64_t& dropped) {
  const std::uint64_t own = (address + kSectorBytes - 1) / kSectorBytes * kSectorBytes;  // no neighbour reads it
  if (l1_.waits(kPrefetch, own)) {
    ++merged;
    return false;
  }
  if (l1_.timed(kPrefetch) >= shared_.config.rt.prefetcher.queue) {
    ++dropped;
    return false;
  }
  const SectorRun run = shared_.traffic.run(kind, address);
  counters_.sectors += run.sectors;
  counters_.responses += run.sectors;
  l1_.push(kPrefetch, 0, run, false, true);
  return true;
}

// Siblings in one line are one access.
void Prefetcher::warm(const traces::NodeDefinition& node, unsigned siblings) {
  std::uint64_t line = 0;
  std::uint8_t sectors = 0;
  Region region{};
  records_.for_each_child(node, siblings, [&](NodeKind kind, std::uint32_t child) {
    const SectorRun run = shared_.traffic.run(kind, shared_.traffic.address(child));
    region = run.region;
    l1_.for_each_line({run.address, run.sectors}, l1_.sectors(), [&](std::uint64_t at, std::uint8_t mask) {
      if (at != line && sectors != 0) l1_.warm(kPrefetch, line, sectors, region, false);
      sectors = at == line ? static_cast<std::uint8_t>(sectors | mask) : mask;
      line = at;
    });
  });
  if (sectors != 0) l1_.warm(kPrefetch, line, sectors, region, false);
}

}  // namespace grtx::sim::fast
