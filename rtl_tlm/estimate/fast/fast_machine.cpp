#include "grtx/rtl_tlm/estimate/fast/fast_machine.h"

#include <algorithm>
#include <bit>

#include "grtx/rtl_tlm/estimate/fast/port_calendar.h"
#include "grtx/rtl_tlm/estimate/fast/timed_share.h"
#include "grtx/rtl_tlm/gpu/built_in_memory.h"

namespace grtx::sim::fast {

using namespace modules;

Machine::Machine(const GpuConfig& config, const traces::Header& header, std::uint64_t eviction_entries,
                 GroupSource& source, unsigned stride)
    : shared_(config, header, eviction_entries, stride),
      distributor_(shared_, source, [this](Cycle seen, unsigned sm, unsigned slot, const traces::RayGroup& group) {
        sms_[sm]->simt.launch(seen, slot, group);
      }) {
  for (unsigned s = 0; s < config.sms; ++s) sms_.push_back(std::make_unique<Sm>(shared_, s, distributor_));
}

void Machine::keep(Machine& before) {
  for (std::size_t i = 0; i < sms_.size(); ++i) sms_[i]->l1.keep(before.sms_[i]->l1);
  shared_.memory.keep(before.shared_.memory);
}

void Machine::save(StateWriter& state) const {
  for (const auto& sm : sms_) sm->l1.save(state);
  shared_.memory.save(state);
}

void Machine::load(StateReader& state) {
  for (const auto& sm : sms_) sm->l1.load(state);
  shared_.memory.load(state);
}

void Machine::run(const std::function<void(std::uint64_t)>& progress) {
  distributor_.report(progress);
  distributor_.launch(0);
  shared_.agenda.run([this](const Due& due) { handle(due); });
  distributor_.finish(shared_.agenda.now());
  shared_.memory.finish();
  for (const auto& sm : sms_) sm->rt.count_stall(distributor_.end());
}

void Machine::handle(const Due& due) {
  const Cycle now = shared_.agenda.now();
  if (now >= advanced_ + PortCalendar::kPeriod) advance(now);
  Sm& sm = *sms_[due.sm];
  switch (due.what) {
    case What::lane:
      return sm.rt.lane_event(now, static_cast<LaneId>(due.index));
    case What::warp:
      return sm.simt.warp_event(now, due.index);
    case What::any_hit_timer:
      return sm.rt.any_hit_due(now, due.index);
    case What::l1_turn:
      return sm.l1.turn(now);
    case What::selection:
      return sm.rt.select(now);
    case What::l1_fill:
      return sm.l1.fill(now, due.index);
    case What::touch:
      return sm.rt.touch(now, static_cast<LaneId>(due.index));
    case What::count:
      break;
  }
}

void Machine::advance(Cycle now) {
  advanced_ = now;
  shared_.memory.advance(now);
  for (const auto& sm : sms_) {
    sm->l1.advance(now);
    sm->rt.advance(now);
  }
}

bool Machine::idle() const {
  return distributor_.idle() &&
         std::all_of(sms_.begin(), sms_.end(), [](const auto& sm) { return sm->rt.idle() && sm->l1.idle(); });
}

GpuCounters Machine::counters() const {
  GpuCounters c;
  const auto doublings = static_cast<unsigned>(std::countr_zero(shared_.stride));
  c.cycles = distributor_.end() * shared_.stride;
  c.period_fs = ClockDomain::period_fs(shared_.config.core_mhz);
  c.distributor = distributor_.counters();
  for (const auto& sm : sms_) {
    c.rt_of.push_back(sm->rt.counters());
    scale_up(c.rt_of.back(), doublings);
    c.simt_of.push_back(sm->simt.counters());
    scale_up(c.simt_of.back(), doublings, sm->simt.timed_any_hits(), sm->simt.warming_any_hits());
    c.l1_of.push_back(sm->l1.counters());
    scale_up(c.l1_of.back(), doublings);
  }
  const FastMemory& memory = shared_.memory;
  c.l2_of = memory.slices();
  for (L2Counters& l2 : c.l2_of) scale_up(l2, doublings);
  std::uint64_t packets = 0;
  for (const L2Counters& slice : c.l2_of) packets += slice.requests_in;
  for (CrossbarCounters::Network* network : {&c.crossbar.request, &c.crossbar.reply}) {
    network->packets_in = network->packets_out = packets;
  }
  c.l2_dirty_sectors = memory.dirty_sectors();
  std::vector<DramChannelCounters> channels = memory.channels(), at_end = memory.channels_by(distributor_.end());
  for (auto* all : {&channels, &at_end}) {
    for (DramChannelCounters& channel : *all) scale_up(channel, doublings);
  }
  c.memory = built_in_counters(shared_.config, at_end, memory.dram(channels, c.cycles), channels);
  add_up(c);
  return c;
}

}  // namespace grtx::sim::fast
