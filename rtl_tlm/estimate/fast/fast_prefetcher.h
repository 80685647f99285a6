// The sibling prefetcher in fast mode.
#pragma once

#include <cstdint>

#include "grtx/modules/rt_unit/sibling_prefetcher.h"
#include "grtx/modules/rt_unit/sibling_records.h"
#include "grtx/rtl_tlm/estimate/fast/fast_l1.h"

namespace grtx::sim::fast {

class Prefetcher {
 public:
  Prefetcher(Shared& shared, L1& l1);

  void begin_lane(std::uint32_t lane) { records_.begin(lane); }
  /// The visits of one warp in one cycle begin.
  void begin_warp() { requests_.begin(); }
  /// The lane's visit of group.nodes[definition] found the children in `hit`.
  void note_internal(std::uint32_t lane, const traces::RayGroup& group, std::uint32_t definition, unsigned hit) {
    records_.note(lane, group, definition, hit);
  }
  /// The lane asks for the leaf at `address` (/ kNodeUnit).
  void note_leaf(Cycle now, std::uint32_t lane, const traces::RayGroup& group, std::uint32_t address) {
    if (const modules::Siblings siblings = records_.take(lane, group, address); siblings.mask != 0) {
      prefetch(now, group, siblings);
    }
  }
  /// The same without time.
  void warm_leaf(std::uint32_t lane, const traces::RayGroup& group, std::uint32_t address) {
    if (const modules::Siblings siblings = records_.take(lane, group, address); siblings.mask != 0) {
      warm(group.nodes[siblings.definition], siblings.mask);
    }
  }

  const modules::SiblingPrefetcher::Counters& counters() const { return counters_; }

 private:
  void prefetch(Cycle now, const traces::RayGroup& group, const modules::Siblings& siblings);
  void push(traces::NodeKind kind, std::uint64_t address);
  void warm(const traces::NodeDefinition& node, unsigned siblings);

  Shared& shared_;
  L1& l1_;
  modules::SiblingRecords records_;
  modules::SiblingRequests requests_;
  modules::SiblingPrefetcher::Counters counters_;
};

}  // namespace grtx::sim::fast
