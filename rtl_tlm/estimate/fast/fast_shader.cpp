// The SIMT core in fast mode: the phases of the shaders, each of which loads, computes and stores.
#include <bit>
#include <utility>

#include "grtx/rtl_tlm/estimate/fast/fast_machine.h"

namespace grtx::sim::fast {

using namespace modules;

namespace {

constexpr WarpActivity executing(PhaseKind kind) {
  if (kind == PhaseKind::blend) return WarpActivity::blend;
  if (kind == PhaseKind::any_hit) return WarpActivity::any_hit;
  return WarpActivity::raygen;
}

}  // namespace

void Machine::enter(Cycle now, Sm& sm, Warp& warp, WarpActivity activity) {
  sm.simt.warp_cycles[static_cast<std::size_t>(warp.activity)] += now - warp.since;
  warp.activity = activity;
  warp.since = now;
}

template <typename F>
void Machine::for_each_line(const std::vector<SectorAccess>& sectors, F&& f) const {
  const SectorCacheTags& tags = sms_.front().tags;
  for (std::size_t i = 0; i < sectors.size();) {
    const std::uint64_t line = tags.line_address(sectors[i].address);
    const Region region = sectors[i].region;
    std::uint8_t mask = 0;
    for (; i < sectors.size() && sectors[i].region == region && tags.line_address(sectors[i].address) == line; ++i) {
      const std::uint8_t b = tags.sector_bit(sectors[i].address);
      if ((mask & b) != 0 || static_cast<unsigned>(std::popcount(mask)) == sms_.front().largest) break;
      mask |= b;
    }
    f(line, mask, region);
  }
}

void Machine::start(Cycle now, unsigned s, unsigned slot, Step step) {
  Sm& sm = sms_[s];
  sm.warps[slot].step = step;
  switch (step) {
    case Step::prologue:
      sm.program.prologue(slot, phase_);
      break;
    case Step::evict_move:
      sm.program.evict_move(slot, phase_);
      break;
    case Step::trace_call:
      sm.program.trace_call(slot, phase_);
      break;
    case Step::sort:
      sm.program.sort(slot, phase_);
      break;
    case Step::blend:
      sm.program.blend(slot, phase_);
      break;
    default:
      sm.program.epilogue(slot, phase_);
  }
  load(now, s, slot);
}

void Machine::load(Cycle now, unsigned s, unsigned slot) {
  Sm& sm = sms_[s];
  Warp& warp = sm.warps[slot];
  warp.kind = phase_.kind;
  warp.instructions = phase_.instructions;
  warp.stores.swap(phase_.stores);
  warp.loads_seen = 0;
  warp.shortened = stride_ > 1 && warp.kind != PhaseKind::any_hit;  // any-hit shaders of other events are not timed
  if (phase_.loads.empty()) return issue(now, s, slot);
  enter(now, sm, warp, WarpActivity::memory);
  warp.loading = true;
  warp.loads_from = now;
  warp.loads_timed = 0;
  const Number number = warp_number(s, slot);
  RingQueue<Request>& queue = sm.ports[kSimt].queue;
  const bool idle = queue.empty();
  const std::uint64_t key = warp.shortened ? draw() : 0;
  for_each_line(phase_.loads, [&](std::uint64_t line, std::uint8_t mask, Region region) {
    if (warp.shortened && !chosen(line, key)) return warm_line(s, sm, kSimt, line, mask, region, false);
    sm.simt.memory.loads[static_cast<std::size_t>(region)] += static_cast<unsigned>(std::popcount(mask));
    ++warp.loads_pending;
    ++warp.loads_timed;
    queue.push({line, number, mask, region, false, true});
  });
  if (warp.loads_timed == 0) return wheel_.add(now + usual_wait_ / (16 * stride_), number);
  sm.waiting |= 1u << kSimt;
  if (idle) serve(now, s);
}

// What the requests of a shortened phase take one after the other is as much less than a whole one's as there are fewer
// of them; the rest of its wait is not.
Cycle Machine::loaded(const Warp& warp, Cycle seen) {
  if (!warp.shortened) return seen;
  const Cycle wait = seen - std::min(seen, warp.loads_from);
  usual_wait_ += wait - usual_wait_ / 16;
  const Cycle in_turn = std::min<Cycle>(wait, warp.loads_timed);
  return warp.loads_from + in_turn + (wait - in_turn) / stride_;
}

void Machine::issue(Cycle now, unsigned s, unsigned slot) {
  Sm& sm = sms_[s];
  Warp& warp = sm.warps[slot];
  enter(now, sm, warp, executing(warp.kind));
  sm.simt.instructions[static_cast<std::size_t>(warp.kind)] += warp.instructions;
  ++sm.simt.phases[static_cast<std::size_t>(warp.kind)];
  if (!warp.shortened) return wheel_.add(sm.issue.reserve(slot, warp.instructions, now), warp_number(s, slot));
  instructions_left_ += warp.instructions;
  const Cycle latency = config_.simt.instruction_latency;
  const Cycle issued = sm.issue.reserve(slot, instructions_left_ / stride_, now) - latency;
  instructions_left_ %= stride_;
  wheel_.add(issued + latency / stride_, warp_number(s, slot));
}

void Machine::store(Cycle now, unsigned s, unsigned slot) {
  Sm& sm = sms_[s];
  Warp& warp = sm.warps[slot];
  if (warp.stores.empty()) return;
  const Number number = warp_number(s, slot);
  RingQueue<Request>& queue = sm.ports[kSimt].queue;
  const bool idle = queue.empty();
  const std::uint64_t key = warp.shortened ? draw() : 0;
  for_each_line(warp.stores, [&](std::uint64_t line, std::uint8_t mask, Region region) {
    if (warp.shortened && !chosen(line, key)) return warm_line(s, sm, kSimt, line, mask, region, true);
    sm.simt.memory.stores[static_cast<std::size_t>(region)] += static_cast<unsigned>(std::popcount(mask));
    ++warp.stores_pending;
    queue.push({line, number, mask, region, true, true});
  });
  warp.stores.clear();
  if (queue.empty()) return;
  sm.waiting |= 1u << kSimt;
  if (idle) serve(now, s);
}

// The warp's loads are there, its phase has been executed, its call has left the RT unit, or its stores are done.
void Machine::warp_event(Cycle now, unsigned s, unsigned slot) {
  Sm& sm = sms_[s];
  Warp& warp = sm.warps[slot];
  if (std::exchange(warp.loading, false)) return issue(now, s, slot);
  if (warp.in_service) return service_ends(now, s, slot);
  if (warp.step != Step::tracing && warp.step != Step::draining) store(now, s, slot);
  switch (warp.step) {
    case Step::launched:
      start(now, s, slot, Step::prologue);
      break;
    case Step::prologue:
    case Step::blend:
      if (sm.program.active_lanes(slot) == 0) {
        start(now, s, slot, Step::epilogue);
      } else {
        start(now, s, slot, sm.program.moves_evictions() ? Step::evict_move : Step::trace_call);
      }
      break;
    case Step::evict_move:
      start(now, s, slot, Step::trace_call);
      break;
    case Step::trace_call:
      warp.step = Step::tracing;
      enter(now, sm, warp, WarpActivity::trace);
      sm.waiting_calls.push(static_cast<std::uint16_t>(slot));
      accept(now + config_.sm_links.message_latency, s);
      break;
    case Step::tracing:
    case Step::sort:
      start(now, s, slot, sm.program.sorts(slot) ? Step::sort : Step::blend);
      break;
    case Step::epilogue:
      warp.step = Step::draining;
      enter(now, sm, warp, WarpActivity::drain);
      if (warp.stores_pending == 0) wheel_.add(std::max(now, warp.stores_seen), warp_number(s, slot));
      break;
    case Step::draining:
      ended(now, s, slot);
  }
}

void Machine::service_ends(Cycle now, unsigned s, unsigned slot) {
  Sm& sm = sms_[s];
  Warp& warp = sm.warps[slot];
  warp.in_service = false;
  enter(now, sm, warp, WarpActivity::trace);
  store(now, s, slot);
  const Cycle back = now + 1 + config_.sm_links.message_latency;
  for_each_bit(warp.service_lanes, [&](unsigned i) { wheel_.add(back, lane_number(s, warp.entry, i)); });
}

}  // namespace grtx::sim::fast
