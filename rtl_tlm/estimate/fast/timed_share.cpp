#include "grtx/rtl_tlm/estimate/fast/timed_share.h"

namespace grtx::sim::fast {
namespace {

template <typename C>
void double_up(C& c, unsigned doublings) {
  for (; doublings > 0; --doublings) c.add(C(c));
}
template <typename C>
void add_up(C& c, unsigned doublings) {
  for (; doublings > 0; --doublings) c += C(c);
}

}  // namespace

void scale_up(modules::RtUnitCounters& c, unsigned doublings) {
  const modules::RtUnitCounters exact = c;
  double_up(c, doublings);
  c.units = exact.units;
  c.warp_buffer.calls = exact.warp_buffer.calls;
  c.warp_buffer.warp_latency = exact.warp_buffer.warp_latency.stretched(doublings);
  c.scheduler.visits_internal = exact.scheduler.visits_internal;
  c.scheduler.visits_instance = exact.scheduler.visits_instance;
  c.scheduler.visits_leaf = exact.scheduler.visits_leaf;
  c.scheduler.culls = exact.scheduler.culls;
  c.scheduler.replay_takes = exact.scheduler.replay_takes;
  c.scheduler.replay_forwards = exact.scheduler.replay_forwards;
  c.scheduler.any_hit_calls = exact.scheduler.any_hit_calls;
  c.scheduler.intersection_calls = exact.scheduler.intersection_calls;
  c.memory.visits = exact.memory.visits;
  c.checkpoint.entries_written = exact.checkpoint.entries_written;
  c.checkpoint.entries_read = exact.checkpoint.entries_read;
  c.stack.moved_out = exact.stack.moved_out;
  c.stack.moved_in = exact.stack.moved_in;
}

void scale_up(modules::SimtCounters& c, unsigned doublings, const AnyHitWork& timed, const AnyHitWork& warming) {
  constexpr auto kAnyHit = static_cast<std::size_t>(modules::PhaseKind::any_hit);
  constexpr auto kIntersection = static_cast<std::size_t>(modules::PhaseKind::intersection);
  const modules::SimtCounters exact = c;
  double_up(c, doublings);
  c.warps = exact.warps;
  c.shader = exact.shader;
  const auto all = [doublings](std::uint64_t counted, std::uint64_t of_timed, std::uint64_t of_warming) {
    return counted - of_warming - of_timed + (of_timed << doublings);
  };
  c.shader.any_hit_batches = all(exact.shader.any_hit_batches, timed.batches, warming.batches);
  c.shader.intersection_batches = all(exact.shader.intersection_batches, timed.intersections, warming.intersections);
  c.shader.load_instructions = all(exact.shader.load_instructions, timed.loads, warming.loads);
  c.shader.store_instructions = all(exact.shader.store_instructions, timed.stores, warming.stores);
  for (std::size_t i = 0; i < modules::kPhaseKinds; ++i) {  // the other phases are all counted
    if (i == kAnyHit || i == kIntersection) continue;
    c.instructions[i] = exact.instructions[i];
    c.phases[i] = exact.phases[i];
  }
}

void scale_up(modules::L1Counters& c, unsigned doublings) { add_up(c, doublings); }
void scale_up(modules::L2Counters& c, unsigned doublings) { add_up(c, doublings); }
void scale_up(modules::DramChannelCounters& c, unsigned doublings) { add_up(c, doublings); }

}  // namespace grtx::sim::fast
