// The sibling prefetcher in fast mode.
#pragma once

#include <cstdint>

#include "grtx/modules/rt_unit/decide/prefetch_decisions.h"
#include "grtx/rtl_tlm/estimate/fast/fast_l1.h"

namespace grtx::sim::fast {

class Prefetcher : public modules::PrefetchDecisions {
 public:
  Prefetcher(Shared& shared, L1& l1);

  void begin_lane(std::uint32_t lane, unsigned slot, bool replays) {
    const std::size_t ray = std::size_t{slot} * modules::kMaxLanes + lane % modules::kMaxLanes;
    PrefetchDecisions::begin_lane(lane, ray, replays);
  }
  /// The lane asks for the leaf at `address` (in units).
  void note_leaf(Cycle now, std::uint32_t lane, const traces::RayGroup& group, std::uint32_t address) {
    if (const modules::Siblings siblings = take(lane, group, address); siblings.mask != 0) {
      prefetch(now, group, siblings);
    }
  }
  /// The same without time.
  void warm_leaf(std::uint32_t lane, const traces::RayGroup& group, std::uint32_t address) {
    if (const modules::Siblings siblings = take(lane, group, address); siblings.mask != 0) {
      warm(group.nodes[siblings.definition], siblings.mask);
    }
  }

 private:
  void prefetch(Cycle now, const traces::RayGroup& group, const modules::Siblings& siblings);
  void warm(const traces::NodeDefinition& node, unsigned siblings);
  // The queue of the decisions.
  friend modules::PrefetchDecisions;
  bool waits(std::uint64_t address) const;
  bool full() const;
  void push(traces::NodeKind kind, std::uint64_t address);

  Shared& shared_;
  L1& l1_;
};

}  // namespace grtx::sim::fast
