#include "rtl_tlm/fast/fast_gpu.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <stdexcept>

#include "base/error.h"
#include "rtl_tlm/gpu.h"

namespace grtx::tlm {

using modules::bit;
using modules::kNever;

namespace {

// What the SMs share takes their requests out of order by as much as a turn: cycles of four scenes and designs are
// 1.2 % off with turns of 8 (mean size), 1.7 % with 16, which is 3 % faster.
constexpr Cycle kTurn = 8;

const GpuConfig& checked(const GpuConfig& config) {
  if (const Unmodelled lack = unmodelled_by_fast(config)) throw Error("configuration", lack.key, lack.rule);
  return config;
}

}  // namespace

Unmodelled unmodelled_by_fast(const GpuConfig& config) {
  if (config.rt.warp_buffer.spill) return {"rt.warp_buffer.spill", "is not modelled by --mode fast"};
  if (config.rt.memory.by_shader) return {"rt.memory.by_shader", "is not modelled by --mode fast"};
  if (config.rt_units != 1) return {"gpu.rt_units", "must be 1 with --mode fast"};
  if (config.l1.mshr_entries >= DueWheel::kNone) return {"l1.mshr_entries", "must be below 65535 with --mode fast"};
  return {};
}

FastGpu::FastGpu(const sc_core::sc_module_name& module_name, const GpuConfig& config, const traces::Header& header,
                 std::uint64_t eviction_entries, modules::GroupSource& source)
    : sc_module(module_name),
      config_(checked(config)),
      map_(header, memory_map_config(config, header, eviction_entries)),
      source_(source),
      memory_(config, map_.bytes()) {
  for (unsigned i = 0; i < config.sms; ++i) {
    sms_.push_back(std::make_unique<FastSm>(fmt::format("sm{}", i).c_str(), config_, i, header, map_, memory_));
    Work work;
    work.free_slots = config.resident_warps == 64 ? ~LaneMask{0} : bit(config.resident_warps) - 1;
    work.position.resize(config.resident_warps);
    work_.push_back(work);
  }
}

Cycle FastGpu::next_due() const {
  Cycle due = kNever;
  for (const auto& sm : sms_) due = std::min({due, sm->next_due(), sm->next_ended()});
  return due;
}

void FastGpu::advance(Cycle end) {
  for (const auto& sm : sms_) sm->run(end);
  memory_.advance(end);
  ++steps_;
}

void FastGpu::run(const std::function<void(std::uint64_t)>& progress) {
  constexpr std::uint64_t kProgressSteps = 4096;
  const std::uint64_t groups = source_.count();
  Cycle now = 0;
  launch_more(0, 1);
  while (next_group_ < groups || running_ > 0) {
    const Cycle due = next_due();
    if (due == kNever) {
      throw std::runtime_error(
          fmt::format("deadlock in core cycle {}: nothing is due but {} warps run", now, running_));
    }
    now = std::max(now, due) + kTurn;
    advance(now);
    collect_ended(now);
    if (steps_ % kProgressSteps == 0) progress(next_group_ - running_);
  }
  progress(groups);
  if (!secondary_) primary_end_ = end_;
  for (const auto& sm : sms_) sm->settle(end_);
  take_counters(false);
  for (Cycle due = next_due(); due != kNever; due = next_due()) {
    now = std::max(now, due) + kTurn;
    advance(now);
  }
  memory_.drain();
  take_counters(true);
}

// Ends in the order in which the distributor sees them, lower SMs first.
void FastGpu::collect_ended(Cycle end) {
  struct Ended {
    Cycle seen;
    unsigned sm;
    std::uint16_t slot;
  };
  std::vector<Ended> all;
  for (unsigned i = 0; i < sms_.size(); ++i) {
    Ended ended{0, i, 0};
    while (sms_[i]->take_ended(end, ended.seen, ended.slot)) all.push_back(ended);
  }
  std::stable_sort(all.begin(), all.end(), [](const Ended& a, const Ended& b) { return a.seen < b.seen; });
  for (const Ended& ended : all) {
    Work& work = work_[ended.sm];
    work.free_slots |= bit(ended.slot);
    --running_;
    if (observer_ != nullptr) observer_->ended(ended.sm, ended.slot, ended.seen);
    source_.release(work.position[ended.slot]);
    end_ = std::max(end_, ended.seen);
    launch_more(ended.seen, end);
  }
}

// One launch a cycle, to the SMs in turn; the earliest that an SM can still see one is `earliest`.
void FastGpu::launch_more(Cycle seen, Cycle earliest) {
  while (next_group_ < source_.count() && !held_back(seen)) {
    unsigned sm = turn_;
    if (next_group_ < assigned_.size()) {
      sm = assigned_[next_group_];
    } else {
      for (unsigned i = 0; i < config_.sms && work_[sm].free_slots == 0; ++i) sm = (sm + 1) % config_.sms;
    }
    Work& work = work_[sm];
    if (work.free_slots == 0) return;
    modules::LaunchWarp warp;
    warp.slot = static_cast<std::uint16_t>(std::countr_zero(work.free_slots));
    warp.group = ready_ != nullptr ? ready_ : source_.acquire(next_group_);
    ready_ = nullptr;
    last_launch_ = std::max(seen, next_group_ == 0 ? 0 : last_launch_ + 1);
    const Cycle visible = std::max({last_launch_ + config_.sm_links.message_latency, earliest, work.last_visible});
    work.last_visible = visible;
    if (observer_ != nullptr) observer_->launched(sm, warp.slot, *warp.group, last_launch_);
    sms_[sm]->launch(visible, warp);
    work.free_slots &= work.free_slots - 1;
    work.position[warp.slot] = next_group_;
    ++work.launched;
    ++next_group_;
    ++running_;
    turn_ = (sm + 1) % config_.sms;
  }
}

// As WorkDistributor: secondary rays start when all primary ones have ended.
bool FastGpu::held_back(Cycle now) {
  if (secondary_) return false;
  if (ready_ == nullptr) ready_ = source_.acquire(next_group_);
  if (ready_->kind == traces::RayKind::primary) return false;
  if (running_ > 0) return true;
  secondary_ = true;
  primary_end_ = now;
  return false;
}

bool FastGpu::idle() const {
  return memory_.idle() && std::all_of(sms_.begin(), sms_.end(), [](const auto& sm) { return sm->idle(); });
}

// What RT units count per cycle and what a data bus moved is that of the end of the run, the rest is drained.
void FastGpu::take_counters(bool drained) {
  if (!drained) {
    counters_.cycles = end_;
    for (const auto& sm : sms_) counters_.rt_of.push_back(sm->rt());
    counters_.dram_of = memory_.channels();
    return;
  }
  for (unsigned i = 0; i < sms_.size(); ++i) {
    RtUnitCounters rt = sms_[i]->rt();
    rt.scheduler = counters_.rt_of[i].scheduler;
    rt.warp_buffer = counters_.rt_of[i].warp_buffer;
    counters_.rt_of[i] = rt;
    counters_.simt_of.push_back(sms_[i]->simt());
    counters_.l1_of.push_back(sms_[i]->l1());
  }
  counters_.l2_of = memory_.slices();
  std::uint64_t requests = 0;
  for (const modules::L2Counters& slice : counters_.l2_of) requests += slice.requests_in;
  counters_.crossbar.request.packets_in = counters_.crossbar.request.packets_out = requests;
  counters_.crossbar.reply.packets_in = counters_.crossbar.reply.packets_out = memory_.packets();
  counters_.period_fs = modules::ClockDomain::period_fs(config_.core_mhz);
  counters_.distributor.groups = next_group_;
  counters_.distributor.most_on_one_sm = counters_.distributor.fewest_on_one_sm = work_.front().launched;
  for (const Work& work : work_) {
    counters_.distributor.most_on_one_sm = std::max(counters_.distributor.most_on_one_sm, work.launched);
    counters_.distributor.fewest_on_one_sm = std::min(counters_.distributor.fewest_on_one_sm, work.launched);
  }
  counters_.distributor.tail_cycles = end_ - last_launch_;
  counters_.distributor.primary_end = primary_end_;
  counters_.l2_dirty_sectors = memory_.dirty_sectors();
  counters_.dram = memory_.dram(end_);
  counters_.dram_channels = memory_.channels();
  add_up(counters_);
}

}  // namespace grtx::tlm
