// The sibling prefetcher in fast mode.
#pragma once

#include <cstdint>
#include <span>

#include "grtx/modules/rt_unit/decide/sibling_records.h"
#include "grtx/modules/rt_unit/sibling_prefetcher.h"
#include "grtx/rtl_tlm/estimate/fast/fast_l1.h"

namespace grtx::sim::fast {

class Prefetcher {
 public:
  Prefetcher(Shared& shared, L1& l1);

  void begin_lane(std::uint32_t lane, unsigned slot, bool replays, const traces::RayGroup& group,
                  std::span<const traces::Event> events) {
    records_.begin(lane, std::size_t{slot} * modules::kMaxLanes + lane % modules::kMaxLanes, replays);
    if (stacks_.enabled()) stacks_.begin(lane, group, events);
  }
  /// The visits of one warp in one cycle begin.
  void begin_warp() { requests_.begin(); }
  /// The lane's visit of group.nodes[definition] pushed the children in `hit` and checkpointed those in `checkpointed`.
  void note_internal(std::uint32_t lane, const traces::RayGroup& group, std::uint32_t definition, unsigned hit,
                     unsigned checkpointed) {
    if (siblings_) records_.note(lane, group, definition, hit, checkpointed);
  }
  /// The lane has taken a source entry that names the node at `address` (in units).
  void note_replayed(std::uint32_t lane, std::uint32_t address) { records_.note_replayed(lane, address); }
  /// A source entry that has come names a node, and will be taken.
  void note_entry(Cycle now, traces::NodeKind kind, std::uint64_t address);
  /// The same without time.
  void warm_entry(traces::NodeKind kind, std::uint64_t address);
  bool reads_stacks() const { return stacks_.enabled(); }
  /// The lane's event, with which `left` of the round are left, has moved its stack, of which `on_chip` entries are in
  /// the warp buffer.
  void note_stack(Cycle now, std::uint32_t lane, std::size_t left, std::uint32_t on_chip);
  /// The same without time.
  void warm_stack(std::uint32_t lane, std::size_t left, std::uint32_t on_chip);
  /// The lane asks for the leaf at `address` (in units).
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
  bool push(traces::NodeKind kind, std::uint64_t address, std::uint64_t& merged, std::uint64_t& dropped);
  void warm(const traces::NodeDefinition& node, unsigned siblings);

  Shared& shared_;
  L1& l1_;
  bool siblings_;
  modules::SiblingRecords records_;
  modules::SiblingRequests requests_;
  modules::StackPrefetch stacks_;
  modules::SiblingPrefetcher::Counters counters_;
};

}  // namespace grtx::sim::fast
