// The outline model: a run from its first launch to its last end.
#include "rtl_tlm/sampled/outline_machine.h"

#include "rtl_tlm/gpu.h"
#include "rtl_tlm/trace_source.h"

namespace grtx::tlm::outline {

using namespace modules;

Machine::Machine(const traces::Reader& reader, const std::vector<std::uint64_t>& groups,
                 const std::vector<Launch>& known, const GpuConfig& config,
                 const std::function<void(const traces::RayGroup&)>& decoded)
    : reader_(reader),
      header_(reader.header()),
      groups_(groups),
      known_(known),
      config_(config),
      decoded_(decoded),
      traffic_(header_, config.rt.memory.traffic),
      map_(header_, memory_map_config(config, header_, reader.totals().max_evictions_per_ray)),
      entries_(config.rt.warp_buffer.entries * config.rt_units),
      lanes_(std::size_t{config.sms} * entries_ * kMaxLanes),
      warps_from_(static_cast<Number>(lanes_.size())),
      timers_from_(warps_from_ + config.sms * config.resident_warps),
      ports_from_(timers_from_ + config.sms * entries_),
      selects_from_(ports_from_ + config.sms),
      wheel_(selects_from_ + config.sms),
      memory_(config, config.dram_config(map_.bytes())),
      records_(config.rt.sibling_prefetch ? lanes_.size() * config.rt.prefetcher.records : 0),
      newest_(config.rt.sibling_prefetch ? lanes_.size() : 0),
      checkpoints_(header_.checkpoint ? lanes_.size() : 0) {
  for (unsigned s = 0; s < config.sms; ++s) {
    sms_.push_back(std::make_unique<Sm>(config, header_, map_, s));
    Sm& sm = *sms_.back();
    sm.calls.resize(entries_);
    sm.ages.resize(entries_);
    sm.warps.resize(config.resident_warps);
    sm.free_slots = mask_of(config.resident_warps);
    sm.free_entries = mask_of(entries_);
  }
  for (std::size_t i = 0; i < lanes_.size(); ++i) {
    lanes_[i].sm = static_cast<std::uint16_t>(i / (entries_ * kMaxLanes));
    lanes_[i].entry = static_cast<std::uint16_t>(i / kMaxLanes % entries_);
  }
  for (const NodeKind kind : {NodeKind::internal, NodeKind::instance, NodeKind::triangle, NodeKind::procedural}) {
    units_[static_cast<std::size_t>(kind)] =
        static_cast<std::uint32_t>(traffic_.stored_bytes(kind) / traces::kNodeUnit);
  }
  selection_ = make_warp_selection(config.rt.scheduler.policy);
  result_.group_end.resize(groups.size());
  result_.group_sm.resize(groups.size());
  leaf_latency_ =
      traffic_.leaf_kind() == NodeKind::triangle ? config.rt.ray_triangle.latency : config.rt.ray_sphere.latency;
}

OutlineRun Machine::run() {
  launch(0);
  wheel_.run([this](Number number) {
    const Cycle now = wheel_.now();
    if (now >= advanced_ + PortCalendar::kPeriod) {
      memory_.advance(advanced_ = now);
      for (const auto& sm : sms_) sm->responses.advance(now);
    }
    if (number < warps_from_) {
      tested(now, number, lanes_[number]);
    } else if (number < timers_from_) {
      warp_event(now, number - warps_from_);
    } else if (number < ports_from_) {
      timer_event(now, number - timers_from_);
    } else if (number < selects_from_) {
      sms_[number - ports_from_]->port_timed = false;
      serve(now, number - ports_from_);
    } else {
      select(now, number - selects_from_);
    }
  });
  result_.cycles = end_;
  result_.l2_accesses = memory_.accesses;
  result_.dram = memory_.dram_sectors;
  return std::move(result_);
}

void Machine::launch(Cycle now) {
  while (next_ < groups_.size()) {
    unsigned s = turn_;
    if (next_ < known_.size()) {
      s = known_[next_].sm;
    } else {
      for (unsigned i = 0; i < config_.sms && sms_[s]->free_slots == 0; ++i) s = (s + 1) % config_.sms;
    }
    Sm& sm = *sms_[s];
    if (sm.free_slots == 0) return;
    if (!ready_) {
      reader_.read(groups_[next_], next_group_);
      check_group(next_group_, header_, reader_.path());
      if (decoded_) decoded_(next_group_);
      ready_ = true;
    }
    if (!secondary_ && next_group_.kind != traces::RayKind::primary) {
      if (running_ > 0) return;
      secondary_ = true;
    }
    const auto slot = static_cast<unsigned>(std::countr_zero(sm.free_slots));
    sm.free_slots &= sm.free_slots - 1;
    Warp& warp = sm.warps[slot];
    std::swap(warp.group, next_group_);
    ready_ = false;
    warp.position = next_;
    warp.cursor = {};
    result_.group_sm[next_] = s;
    sm.program.begin(slot, warp.group);
    last_launch_ = std::max(now, next_ == 0 ? 0 : last_launch_ + 1);
    start(last_launch_ + config_.sm_links.message_latency, s, slot, Step::prologue);
    turn_ = (s + 1) % config_.sms;
    ++next_;
    ++running_;
  }
}

void Machine::ended(Cycle now, unsigned s, unsigned slot) {
  Sm& sm = *sms_[s];
  const Cycle seen = now + config_.sm_links.message_latency;
  result_.group_end[sm.warps[slot].position] = seen;
  end_ = std::max(end_, seen);
  sm.free_slots |= bit(slot);
  --running_;
  launch(seen);
}

}  // namespace grtx::tlm::outline

namespace grtx::tlm {

OutlineRun run_outline(const traces::Reader& reader, const std::vector<std::uint64_t>& groups,
                       const std::vector<Launch>& known, const GpuConfig& config,
                       const std::function<void(const traces::RayGroup&)>& decoded) {
  return outline::Machine(reader, groups, known, config, decoded).run();
}

}  // namespace grtx::tlm
