#include "grtx/rtl_tlm/estimate/fast/fast_stacks.h"

#include <algorithm>

#include "grtx/modules/rt_unit/decide/stack_entry.h"

namespace grtx::sim::fast {

using namespace modules;

Stacks::Stacks(Shared& shared, unsigned sm, L1& l1)
    : shared_(shared),
      sm_(sm),
      l1_(l1),
      spill_(shared.config.rt.warp_buffer.stack_entries, stack_entry_layout(shared.header.pop_test).in_a_sector),
      lanes_(std::size_t{shared.config.rt.warp_buffer.entries} * kMaxLanes) {}

StackSpill::Move Stacks::move(Lane& lane, std::uint32_t depth, bool takes_top) {
  const StackSpill::Move move = spill_.settle(lane.stack, depth, takes_top);
  counters_.note(lane.stack, move);
  return move;
}

Cycle Stacks::settle(Cycle now, std::uint32_t lane, std::uint32_t depth, bool takes_top) {
  Lane& of = lanes_[lane];
  const StackSpill::Move move = this->move(of, depth, takes_top);
  if (!move.any()) return now;
  const unsigned sectors = move.fill ? 1 : move.spills;
  Cycle sent = now;
  for (unsigned i = 0; i < sectors; ++i) {
    sent = std::max(sent, port_.reserve(now));
    const std::uint64_t address = shared_.map.stack_sector(of.ray, move.first + i);
    l1_.push(kStack, lane, {address, 1, Region::stack}, !move.fill, true);
  }
  (move.fill ? counters_.fills : counters_.spills) += sectors;
  // The link takes as many as it holds, the L1 one a cycle from it.
  const std::size_t queued = l1_.timed(kStack), most = shared_.config.sm_links.l1_capacity;
  if (queued > most) sent = std::max(sent, now + queued - most);
  if (l1_.queued(kStack) == sectors) l1_.serve(now);
  return move.fill ? kNever : sent;
}

void Stacks::warm(std::uint32_t lane, std::uint32_t depth, bool takes_top) {
  Lane& of = lanes_[lane];
  const StackSpill::Move move = this->move(of, depth, takes_top);
  const unsigned sectors = move.fill ? 1 : move.spills;
  for (unsigned i = 0; i < sectors; ++i) {
    l1_.warm(kStack, {shared_.map.stack_sector(of.ray, move.first + i), Region::stack}, !move.fill);
  }
}

void Stacks::answered(std::uint32_t lane, Cycle seen, bool write) {
  if (write) {
    ++counters_.acknowledged;
    return;
  }
  ++counters_.returned;
  shared_.agenda.add(seen, {What::lane, sm_, lane});
}

}  // namespace grtx::sim::fast
