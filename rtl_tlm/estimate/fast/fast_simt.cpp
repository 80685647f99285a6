#include "grtx/rtl_tlm/estimate/fast/fast_simt.h"

#include <algorithm>
#include <bit>
#include <utility>

#include "grtx/rtl_tlm/estimate/fast/distributor.h"
#include "grtx/rtl_tlm/estimate/fast/fast_rt_unit.h"

namespace grtx::sim::fast {

using namespace modules;

Simt::Simt(Shared& shared, unsigned sm, L1& l1, RtUnit& rt, Distributor& distributor)
    : shared_(shared),
      sm_(sm),
      l1_(l1),
      rt_(rt),
      distributor_(distributor),
      program_(shared.header, shared.map, shared.config.simt.costs, sm, shared.config.resident(),
               shared.config.simt.private_store),
      issue_(shared.config.simt.schedulers, shared.config.simt.instruction_latency),
      store_(shared.config.simt.private_store),
      warps_(shared.config.resident()) {}

void Simt::launch(Cycle seen, unsigned slot, const traces::RayGroup& group) {
  Warp& warp = warps_[slot];
  warp.group = &group;
  program_.begin(slot, group);
  warp.activity = WarpActivity::raygen;
  warp.since = seen;
  warp.step = Step::launched;
  warp.first_timed = static_cast<std::uint32_t>(shared_.draw() % shared_.stride);
  add(seen, slot);
}

void Simt::enter(Cycle now, Warp& warp, WarpActivity activity) {
  counters_.warp_cycles[static_cast<std::size_t>(warp.activity)] += now - warp.since;
  warp.activity = activity;
  warp.since = now;
}

template <typename F>
void Simt::for_each_line(std::span<const SectorAccess> sectors, F&& f) const {
  const SectorCacheTags& tags = l1_.tags();
  for (std::size_t i = 0; i < sectors.size();) {
    const std::uint64_t line = tags.line_address(sectors[i].address);
    const Region region = sectors[i].region;
    std::uint8_t mask = 0;
    for (; i < sectors.size() && sectors[i].region == region && tags.line_address(sectors[i].address) == line; ++i) {
      const std::uint8_t b = tags.sector_bit(sectors[i].address);
      if ((mask & b) != 0 || static_cast<unsigned>(std::popcount(mask)) == l1_.largest()) break;
      mask |= b;
    }
    f(line, mask, region);
  }
}

void Simt::start(Cycle now, unsigned slot, Step step) {
  warps_[slot].step = step;
  switch (step) {
    case Step::prologue:
      program_.prologue(slot, shared_.phase);
      break;
    case Step::evict_move:
      program_.evict_move(slot, shared_.phase);
      break;
    case Step::trace_call:
      program_.trace_call(slot, shared_.phase);
      break;
    case Step::sort:
      program_.sort(slot, shared_.phase);
      break;
    case Step::blend:
      program_.blend(slot, shared_.phase);
      break;
    default:
      program_.epilogue(slot, shared_.phase);
  }
  const std::uint64_t turn =
      program_.round(slot) + warps_[slot].first_timed + static_cast<unsigned>(shared_.phase.kind);
  if (turn % shared_.stride == 0) return load(now, slot);
  warm_phase(slot);
  warp_event(now, slot);
}

void Simt::warm_phase(unsigned slot) {
  const ShaderPhase& phase = shared_.phase;
  for (const SectorAccess& sector : phase.loads) l1_.warm(kSimt, sector, false);
  for (const SectorAccess& sector : phase.stores) l1_.warm(kSimt, sector, true);
  counters_.instructions[static_cast<std::size_t>(phase.kind)] += phase.instructions;
  ++counters_.phases[static_cast<std::size_t>(phase.kind)];
  Warp& warp = warps_[slot];
  warp.stores.clear();
  warp.store_writes = 0;
  warp.steps.clear();
  warp.next_step = 0;
}

void Simt::load(Cycle now, unsigned slot) {
  Warp& warp = warps_[slot];
  warp.kind = shared_.phase.kind;
  warp.instructions = shared_.phase.instructions;
  warp.stores.swap(shared_.phase.stores);
  warp.store_writes = shared_.phase.store_writes;
  warp.loads_seen = 0;
  warp.steps.swap(shared_.phase.steps);
  warp.next_step = 0;
  if (!warp.steps.empty()) {
    warp.loads.swap(shared_.phase.loads);
    warp.step_instructions = shared_.phase.step_instructions;
    return load_step(now, slot);
  }
  if (shared_.phase.loads.empty() && shared_.phase.store_reads == 0) return issue(now, slot);
  send_loads(now, slot, shared_.phase.loads, shared_.phase.store_reads);
}

void Simt::load_step(Cycle now, unsigned slot) {
  Warp& warp = warps_[slot];
  const LoadStep begin = warp.next_step == 0 ? LoadStep{} : warp.steps[warp.next_step - 1];
  const LoadStep end = warp.steps[warp.next_step++];
  warp.loads_seen = 0;
  send_loads(now, slot, std::span(warp.loads).subspan(begin.loads, end.loads - begin.loads),
             end.store_reads - begin.store_reads);
}

void Simt::send_loads(Cycle now, unsigned slot, std::span<const SectorAccess> loads, std::uint32_t store_reads) {
  Warp& warp = warps_[slot];
  enter(now, warp, WarpActivity::memory);
  warp.loading = true;
  warp.store_read = store_reads == 0 ? now : store_.read(store_reads, now);
  if (loads.empty()) return add(warp.store_read, slot);
  const bool idle = l1_.idle(kSimt);
  for_each_line(loads, [&](std::uint64_t line, std::uint8_t mask, Region region) {
    counters_.memory.loads[static_cast<std::size_t>(region)] += static_cast<unsigned>(std::popcount(mask));
    ++warp.loads_pending;
    l1_.push(kSimt, {line, slot, mask, region, false, true});
  });
  if (idle) l1_.serve(now);
}

void Simt::issue(Cycle now, unsigned slot) {
  Warp& warp = warps_[slot];
  enter(now, warp, activity_of(warp.kind));
  const bool last = warp.next_step >= warp.steps.size();
  const std::uint64_t instructions = last ? warp.instructions : warp.step_instructions;
  warp.instructions -= instructions;
  counters_.instructions[static_cast<std::size_t>(warp.kind)] += instructions;
  if (last) ++counters_.phases[static_cast<std::size_t>(warp.kind)];
  add(issue_.reserve(slot, instructions, now), slot);
}

void Simt::store(Cycle now, unsigned slot) {
  Warp& warp = warps_[slot];
  if (warp.store_writes > 0) store_.write(std::exchange(warp.store_writes, 0), now);
  if (warp.stores.empty()) return;
  const bool idle = l1_.idle(kSimt);
  for_each_line(warp.stores, [&](std::uint64_t line, std::uint8_t mask, Region region) {
    counters_.memory.stores[static_cast<std::size_t>(region)] += static_cast<unsigned>(std::popcount(mask));
    ++warp.stores_pending;
    l1_.push(kSimt, {line, slot, mask, region, true, true});
  });
  warp.stores.clear();
  if (idle && !l1_.idle(kSimt)) l1_.serve(now);
}

void Simt::warp_event(Cycle now, unsigned slot) {
  Warp& warp = warps_[slot];
  if (std::exchange(warp.loading, false)) return issue(now, slot);
  if (warp.next_step < warp.steps.size()) return load_step(now, slot);
  if (warp.in_service) return service_ends(now, slot);
  if (warp.step != Step::tracing && warp.step != Step::draining) store(now, slot);
  switch (warp.step) {
    case Step::launched:
      start(now, slot, Step::prologue);
      break;
    case Step::prologue:
    case Step::blend:
      if (program_.blends_on(slot)) {
        start(now, slot, Step::sort);
      } else if (program_.active_lanes(slot) == 0) {
        start(now, slot, Step::epilogue);
      } else {
        start(now, slot, program_.moves_evictions() ? Step::evict_move : Step::trace_call);
      }
      break;
    case Step::evict_move:
      start(now, slot, Step::trace_call);
      break;
    case Step::trace_call:
      warp.step = Step::tracing;
      enter(now, warp, WarpActivity::trace);
      rt_.call(now + shared_.config.sm_links.message_latency,
               {warp.group, program_.round(slot), static_cast<std::uint16_t>(slot), program_.active_lanes(slot)});
      break;
    case Step::tracing:
    case Step::sort:
      start(now, slot, program_.sorts(slot) ? Step::sort : Step::blend);
      break;
    case Step::epilogue:
      warp.step = Step::draining;
      enter(now, warp, WarpActivity::drain);
      if (warp.stores_pending == 0) add(std::max(now, warp.stores_seen), slot);
      break;
    case Step::draining:
      enter(now, warp, warp.activity);
      ++counters_.warps;
      distributor_.ended(now, sm_, slot);
  }
}

void Simt::service_ends(Cycle now, unsigned slot) {
  Warp& warp = warps_[slot];
  if (warp.hits.lanes != 0) {
    const AnyHitBatch hits = warp.hits;
    warp.hits.lanes = 0;
    return start_any_hit(now, hits);
  }
  warp.in_service = false;
  enter(now, warp, WarpActivity::trace);
  store(now, slot);
  rt_.any_hit_done(now + 1 + shared_.config.sm_links.message_latency, warp.entry, warp.service_lanes);
}

void Simt::answered(std::uint32_t slot, Cycle seen, bool write) {
  Warp& warp = warps_[slot];
  if (write) {
    warp.stores_seen = std::max(warp.stores_seen, seen);
    if (--warp.stores_pending == 0 && warp.step == Step::draining) add(warp.stores_seen, slot);
    return;
  }
  warp.loads_seen = std::max(warp.loads_seen, seen);
  if (--warp.loads_pending == 0) add(std::max(warp.loads_seen, warp.store_read), slot);
}

void Simt::serve(Cycle now, unsigned entry, const AnyHitBatch& batch) {
  Warp& warp = warps_[batch.slot];
  warp.entry = entry;
  warp.service_lanes = batch.lanes;
  warp.in_service = true;
  if (!program_.intersects()) return start_any_hit(now, batch);
  warp.hits = ShaderProgram::hits_of(batch);
  run_intersection(batch, timed_any_hits_);
  load(now, batch.slot);
}

void Simt::start_any_hit(Cycle now, const AnyHitBatch& batch) {
  run_any_hit(batch, timed_any_hits_);
  if (!program_.inserts_at_store()) return load(now, batch.slot);
  Warp& warp = warps_[batch.slot];
  warp.kind = PhaseKind::any_hit;
  warp.stores.swap(shared_.phase.stores);
  warp.store_writes = shared_.phase.store_writes;
  warp.steps.clear();
  warp.next_step = 0;
  enter(now, warp, WarpActivity::any_hit);
  add(store_.insert(batch.lanes, shared_.phase.insertion_accesses, now), batch.slot);
}

void Simt::warm_any_hit(const AnyHitBatch& batch) {
  if (!program_.intersects()) {
    run_any_hit(batch, warming_any_hits_);
    return warm_accesses();
  }
  run_intersection(batch, warming_any_hits_);
  warm_accesses();
  const AnyHitBatch hits = ShaderProgram::hits_of(batch);
  if (hits.lanes == 0) return;
  run_any_hit(hits, warming_any_hits_);
  warm_accesses();
}

void Simt::warm_accesses() {
  for (const SectorAccess& sector : shared_.phase.loads) l1_.warm(kSimt, sector, false);
  for (const SectorAccess& sector : shared_.phase.stores) l1_.warm(kSimt, sector, true);
}

void Simt::run_any_hit(const AnyHitBatch& batch, AnyHitWork& counted) {
  const ShaderCounters& counters = program_.counters();
  const std::uint64_t loads = counters.load_instructions, stores = counters.store_instructions;
  program_.any_hit(batch, shared_.phase);
  ++counted.batches;
  counted.loads += counters.load_instructions - loads;
  counted.stores += counters.store_instructions - stores;
}

void Simt::run_intersection(const AnyHitBatch& batch, AnyHitWork& counted) {
  const std::uint64_t loads = program_.counters().load_instructions;
  program_.intersection(batch, shared_.phase);
  ++counted.intersections;
  counted.loads += program_.counters().load_instructions - loads;
}

SimtCounters Simt::counters() const {
  SimtCounters counters = counters_;
  counters.issue_busy_cycles = issue_.busy_cycles();
  counters.issue_wait_cycles = issue_.wait_cycles();
  counters.shader = program_.counters();
  counters.private_store = store_.counters();
  return counters;
}

}  // namespace grtx::sim::fast
