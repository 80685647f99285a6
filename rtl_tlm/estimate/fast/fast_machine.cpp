// A run in fast mode from its first launch to its last end, and what it counted.
#include "grtx/rtl_tlm/estimate/fast/fast_machine.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <stdexcept>

#include "grtx/base/error.h"
#include "grtx/rtl_tlm/gpu/gpu.h"

namespace grtx::sim::fast {

using namespace modules;
using traces::NodeKind;

Machine::Machine(const GpuConfig& config, const traces::Header& header, std::uint64_t eviction_entries,
                 GroupSource& source, unsigned stride)
    : config_(config),
      header_(header),
      source_(source),
      traffic_(header, config.rt.memory.traffic),
      map_(header, memory_map_config(config, header, eviction_entries)),
      one_by_one_(config.sm_links.l1_capacity == 1),
      entries_(config.rt.warp_buffer.entries),
      lanes_(std::size_t{config.sms} * entries_ * kMaxLanes),
      warps_from_(static_cast<Number>(lanes_.size())),
      timers_from_(warps_from_ + config.sms * config.resident_warps),
      ports_from_(timers_from_ + config.sms * entries_),
      selects_from_(ports_from_ + config.sms),
      fills_from_(selects_from_ + config.sms),
      fills_(static_cast<Number>(Sm::fills_of(config))),
      wheel_(fills_from_ + config.sms * fills_),
      memory_(config, map_.bytes()),
      checkpoints_(header.checkpoint ? lanes_.size() : 0),
      selection_(make_warp_selection(config.rt.scheduler.policy)),
      stride_(stride),
      drawn_(config.fast.seed * 0xD1B54A32D192ED03u),
      usual_wait_(16 * Cycle{config.l2.latency}) {
  sms_.reserve(config.sms);
  for (unsigned s = 0; s < config.sms; ++s) {
    sms_.emplace_back(config_, header_, map_, s, traffic_.leaf_kind());
  }
  for (std::size_t i = 0; i < lanes_.size(); ++i) {
    lanes_[i].sm = static_cast<std::uint16_t>(i / (entries_ * kMaxLanes));
    lanes_[i].entry = static_cast<std::uint16_t>(i / kMaxLanes % entries_);
  }
  if (config.rt.sibling_prefetch) records_.emplace(lanes_.size(), config.rt.prefetcher.records, traffic_);
  if (header.checkpoint) {
    layout_.emplace(header.checkpoint_order, header.checkpoint_capacity, config.rt.checkpoint.write_combine,
                    config.rt.checkpoint.read_buffer);
  }
}

void Machine::run(const std::function<void(std::uint64_t)>& progress) {
  progress_ = progress;
  launch(0);
  wheel_.run([this](Number number) { handle_event(number); });
  if (running_ > 0 || next_group_ < source_.count()) {
    throw std::runtime_error(
        fmt::format("deadlock in core cycle {}: nothing is due but {} warps run", wheel_.now(), running_));
  }
  if (!secondary_) primary_end_ = end_;
  memory_.finish();
  for (Sm& sm : sms_) count_stall(end_, sm);
  progress(ended_);
}

void Machine::handle_event(Number number) {
  const Cycle now = wheel_.now();
  if (now >= advanced_ + PortCalendar::kPeriod) advance(now);
  if (number < warps_from_) {
    lane_event(now, number, lanes_[number]);
  } else if (number < timers_from_) {
    const Number warp = number - warps_from_;
    warp_event(now, warp / config_.resident_warps, warp % config_.resident_warps);
  } else if (number < ports_from_) {
    const unsigned s = (number - timers_from_) / entries_, entry = (number - timers_from_) % entries_;
    Call& call = sms_[s].calls[entry];
    call.timing = false;
    if (call.waiting_any_hit != 0) consider_any_hit(now, s, entry);
  } else if (number < selects_from_) {
    sms_[number - ports_from_].port_timed = false;
    serve(now, number - ports_from_);
  } else if (number < fills_from_) {
    select(now, number - selects_from_);
  } else {
    fill(now, (number - fills_from_) / fills_, (number - fills_from_) % fills_);
  }
}

void Machine::advance(Cycle now) {
  advanced_ = now;
  memory_.advance(now);
  for (Sm& sm : sms_) {
    sm.responses.advance(now);
    sm.banks.advance(now);
    for (Unit* unit : {&sm.box, &sm.leaf, &sm.transform}) unit->places.advance(now);
    sm.hand_over.advance(now);
  }
}

void Machine::refuse(Number number, const char* rule) const {
  const Lane& lane = lanes_[number];
  const Sm& sm = sms_[lane.sm];
  throw Error("trace",
              fmt::format("group {} lane {} round {}", group_of(lane).index, number % kMaxLanes,
                          sm.program.round(sm.calls[lane.entry].slot)),
              rule);
}

// One launch a cycle, to the SMs in turn.
void Machine::launch(Cycle now) {
  while (next_group_ < source_.count() && !held_back(now)) {
    unsigned s = turn_;
    if (next_group_ < assigned_.size()) {
      s = assigned_[next_group_];
    } else {
      for (unsigned i = 0; i < config_.sms && sms_[s].free_slots == 0; ++i) s = (s + 1) % config_.sms;
    }
    Sm& sm = sms_[s];
    if (sm.free_slots == 0) return;
    const auto slot = static_cast<unsigned>(std::countr_zero(sm.free_slots));
    sm.free_slots &= sm.free_slots - 1;
    Warp& warp = sm.warps[slot];
    warp.group = acquired_ != nullptr ? acquired_ : source_.acquire(next_group_);
    acquired_ = nullptr;
    warp.position = next_group_;
    warp.cursor = {};
    sm.program.begin(slot, *warp.group);
    last_launch_ = std::max(now, next_group_ == 0 ? 0 : last_launch_ + 1);
    if (observer_ != nullptr) observer_->launched(s, slot, *warp.group, whole(last_launch_));
    const Cycle seen = last_launch_ + config_.sm_links.message_latency;
    warp.activity = WarpActivity::raygen;
    warp.since = seen;
    warp.step = Step::launched;
    wheel_.add(seen, warp_number(s, slot));
    turn_ = (s + 1) % config_.sms;
    ++sm.launched;
    ++next_group_;
    ++running_;
  }
}

// As WorkDistributor: secondary rays start when all primary ones have ended.
bool Machine::held_back(Cycle now) {
  if (secondary_) return false;
  if (acquired_ == nullptr) acquired_ = source_.acquire(next_group_);
  if (acquired_->kind == traces::RayKind::primary) return false;
  if (running_ > 0) return true;
  secondary_ = true;
  primary_end_ = now;
  return false;
}

void Machine::ended(Cycle now, unsigned s, unsigned slot) {
  constexpr std::uint64_t kProgressGroups = 8;
  Sm& sm = sms_[s];
  Warp& warp = sm.warps[slot];
  enter(now, sm, warp, warp.activity);
  ++sm.simt.warps;
  const Cycle seen = now + config_.sm_links.message_latency;
  if (observer_ != nullptr) observer_->ended(s, slot, whole(seen));
  source_.release(warp.position);
  warp.group = nullptr;
  end_ = std::max(end_, seen);
  sm.free_slots |= bit(slot);
  --running_;
  if (++ended_ % kProgressGroups == 0) progress_(ended_);
  launch(seen);
}

bool Machine::idle() const {
  return running_ == 0 && std::all_of(sms_.begin(), sms_.end(), [](const Sm& sm) {
           return sm.occupied == 0 && sm.waiting_calls.empty() &&
                  std::all_of(sm.ports.begin(), sm.ports.end(), [](const Port& port) { return port.queue.empty(); });
         });
}

GpuCounters Machine::counters() const {
  GpuCounters c;
  const auto doublings = static_cast<unsigned>(std::countr_zero(stride_));
  c.cycles = whole(end_);
  c.period_fs = ClockDomain::period_fs(config_.core_mhz);
  c.distributor.groups = next_group_;
  c.distributor.most_on_one_sm = c.distributor.fewest_on_one_sm = sms_.front().launched;
  c.distributor.tail_cycles = whole(end_ - last_launch_);
  c.distributor.primary_end = whole(primary_end_);
  for (const Sm& sm : sms_) {
    c.distributor.most_on_one_sm = std::max(c.distributor.most_on_one_sm, sm.launched);
    c.distributor.fewest_on_one_sm = std::min(c.distributor.fewest_on_one_sm, sm.launched);
    modules::RtUnitCounters rt = sm.rt;
    rt.ray_box = sm.box.counters;
    (traffic_.leaf_kind() == NodeKind::triangle ? rt.ray_triangle : rt.ray_sphere) = sm.leaf.counters;
    rt.ray_transform = sm.transform.counters;
    scale_up(rt, doublings);
    c.rt_of.push_back(rt);
    SimtCounters simt = sm.simt;
    simt.issue_busy_cycles = sm.issue.busy_cycles();
    simt.issue_wait_cycles = sm.issue.wait_cycles();
    simt.shader = sm.program.counters();
    scale_up(simt, doublings, sm.timed_any_hits, sm.warming_any_hits);
    c.simt_of.push_back(simt);
    L1Counters l1 = sm.l1;
    l1.prefetches_unused += sm.tags.count_unused_prefetch();
    scale_up(l1, doublings);
    c.l1_of.push_back(l1);
  }
  c.l2_of = memory_.slices();
  for (L2Counters& l2 : c.l2_of) scale_up(l2, doublings);
  std::uint64_t packets = 0;
  for (const L2Counters& slice : c.l2_of) packets += slice.requests_in;
  for (CrossbarCounters::Network* network : {&c.crossbar.request, &c.crossbar.reply}) {
    network->packets_in = network->packets_out = packets;
  }
  c.l2_dirty_sectors = memory_.dirty_sectors();
  c.dram_of = memory_.channels();
  for (DramChannelCounters& channel : c.dram_of) scale_up(channel, doublings);
  c.dram_channels = c.dram_of;
  c.dram = memory_.dram(c.dram_of, c.cycles);
  add_up(c);
  return c;
}

}  // namespace grtx::sim::fast
