#include "grtx/rtl_tlm/estimate/fast/fast_prefetcher.h"

namespace grtx::sim::fast {

using namespace modules;
using traces::NodeKind;

Prefetcher::Prefetcher(Shared& shared, L1& l1)
    : PrefetchDecisions(std::size_t{shared.config.rt.warp_buffer.entries} * kMaxLanes, shared.config.rt.prefetcher,
                        {shared.config.rt.sibling_prefetch, shared.config.rt.names_siblings_in_entries(shared.header)},
                        shared.traffic),
      shared_(shared),
      l1_(l1) {}

void Prefetcher::prefetch(Cycle now, const traces::RayGroup& group, const Siblings& siblings) {
  const bool idle = l1_.idle(kPrefetch);
  ask_for(siblings, group, *this);
  if (idle) l1_.serve(now);
}

bool Prefetcher::waits(std::uint64_t address) const {
  return l1_.waits(kPrefetch, (address + kSectorBytes - 1) / kSectorBytes * kSectorBytes);  // no neighbour reads it
}

bool Prefetcher::full() const { return l1_.timed(kPrefetch) >= shared_.config.rt.prefetcher.queue; }

void Prefetcher::push(NodeKind kind, std::uint64_t address) {
  const SectorRun run = shared_.traffic.run(kind, address);
  counters().sectors += run.sectors;
  counters().responses += run.sectors;
  l1_.push(kPrefetch, 0, run, false, true);
}

// Siblings in one line are one access.
void Prefetcher::warm(const traces::NodeDefinition& node, unsigned siblings) {
  std::uint64_t line = 0;
  std::uint8_t sectors = 0;
  Region region{};
  records().for_each_child(node, siblings, [&](NodeKind kind, std::uint32_t child) {
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
