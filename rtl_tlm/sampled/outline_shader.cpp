// SIMT core of the outline model: the phases of the shaders, their loads and stores, any-hit batches.
#include "rtl_tlm/sampled/outline_machine.h"

namespace grtx::tlm::outline {

using namespace modules;

void Machine::start(Cycle now, unsigned s, unsigned slot, Step step) {
  Sm& sm = *sms_[s];
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
  Sm& sm = *sms_[s];
  Warp& warp = sm.warps[slot];
  warp.instructions = phase_.instructions;
  warp.stores.swap(phase_.stores);
  warp.loads_seen = 0;
  const Number number = warps_from_ + s * config_.resident_warps + slot;
  const bool idle = sm.ports[kSimt].queue.empty();
  for_each_line(phase_.loads, [&](std::uint64_t line, std::uint8_t mask) {
    ++warp.loads_pending;
    sm.ports[kSimt].queue.push({line, number, mask, kNoPlace, false, true});
  });
  if (warp.loads_pending == 0) {
    wheel_.add(now + 1 + warp.instructions + config_.simt.instruction_latency, number);
  } else if (idle) {
    serve(now, s);
  }
}

void Machine::store(Cycle now, unsigned s, unsigned slot) {
  Sm& sm = *sms_[s];
  Warp& warp = sm.warps[slot];
  if (warp.stores.empty()) return;
  const Number number = warps_from_ + s * config_.resident_warps + slot;
  const bool idle = sm.ports[kSimt].queue.empty();
  for_each_line(warp.stores, [&](std::uint64_t line, std::uint8_t mask) {
    ++warp.stores_pending;
    sm.ports[kSimt].queue.push({line, number, mask, kNoPlace, true, true});
  });
  warp.stores.clear();
  if (idle) serve(now, s);
}

void Machine::warp_event(Cycle now, Number number) {
  const unsigned s = number / config_.resident_warps, slot = number % config_.resident_warps;
  Sm& sm = *sms_[s];
  Warp& warp = sm.warps[slot];
  if (warp.in_service) {
    warp.in_service = false;
    store(now, s, slot);
    Call& call = sm.calls[warp.entry];
    const Cycle back = now + 1 + config_.sm_links.message_latency;
    for_each_bit(warp.service_lanes, [&](unsigned i) {
      const Number lane = lane_number(s, warp.entry, i);
      wheel_.add(back, lane);
    });
    call.in_shader = 0;
    if (call.waiting != 0) consider_any_hit(now, s, warp.entry);
    return;
  }
  if (warp.step != Step::tracing && warp.step != Step::draining) store(now, s, slot);
  switch (warp.step) {
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
      sm.waiting_calls.push(static_cast<std::uint16_t>(slot));
      accept(now + config_.sm_links.message_latency, s);
      break;
    case Step::tracing:
    case Step::sort:
      start(now, s, slot, sm.program.sorts(slot) ? Step::sort : Step::blend);
      break;
    case Step::epilogue:
      warp.step = Step::draining;
      if (warp.stores_pending == 0) wheel_.add(std::max(now, warp.stores_seen), number + warps_from_);
      break;
    case Step::draining:
      ended(now, s, slot);
  }
}

void Machine::consider_any_hit(Cycle now, unsigned s, unsigned entry) {
  Call& call = sms_[s]->calls[entry];
  if (call.in_shader != 0) return;
  const Cycle due = call.since + config_.rt.any_hit.timeout;
  if (call.waiting == call.active || due <= now) return fire(now, s, entry);
  if (call.timing) return;
  call.timing = true;
  wheel_.add(due, timers_from_ + s * entries_ + entry);
}

void Machine::timer_event(Cycle now, Number number) {
  const unsigned s = number / entries_, entry = number % entries_;
  Call& call = sms_[s]->calls[entry];
  call.timing = false;
  if (call.waiting != 0) consider_any_hit(now, s, entry);
}

void Machine::fire(Cycle now, unsigned s, unsigned entry) {
  Sm& sm = *sms_[s];
  Call& call = sm.calls[entry];
  Warp& warp = sm.warps[call.slot];
  AnyHitBatch batch;
  batch.slot = call.slot;
  batch.lanes = call.waiting;
  for_each_bit(call.waiting, [&](unsigned i) {
    const Event& event = *lanes_[lane_number(s, entry, i)].next;
    batch.outcome[i] = event.outcome();
    batch.shifts[i] = static_cast<std::uint16_t>(event.shifts());
  });
  call.in_shader = warp.service_lanes = call.waiting;
  call.waiting = 0;
  warp.in_service = true;
  sm.program.any_hit(batch, phase_);
  load(now + config_.sm_links.message_latency, s, call.slot);
}

}  // namespace grtx::tlm::outline
