#include "grtx/rtl_tlm/estimate/fast/distributor.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <stdexcept>

#include "grtx/rtl_tlm/estimate/fast/lowest_bits.h"

namespace grtx::sim::fast {

using namespace modules;

Distributor::Distributor(const Shared& shared, GroupSource& source, Launch launch)
    : shared_(shared), source_(source), launch_(std::move(launch)), sms_(shared.config.sms) {
  for (Sm& sm : sms_) {
    sm.free_slots = lowest_bits(shared.config.resident_warps);
    sm.position.resize(shared.config.resident_warps);
  }
}

// One launch a cycle, to the SMs in turn.
void Distributor::launch(Cycle now) {
  while (next_group_ < source_.count() && !held_back(now)) {
    const auto sms = static_cast<unsigned>(sms_.size());
    unsigned s = turn_;
    if (next_group_ < assigned_.size()) {
      s = assigned_[next_group_];
    } else {
      for (unsigned i = 0; i < sms && sms_[s].free_slots == 0; ++i) s = (s + 1) % sms;
    }
    Sm& sm = sms_[s];
    if (sm.free_slots == 0) return;
    const auto slot = static_cast<unsigned>(std::countr_zero(sm.free_slots));
    sm.free_slots &= sm.free_slots - 1;
    const traces::RayGroup& group = *(acquired_ != nullptr ? acquired_ : source_.acquire(next_group_));
    acquired_ = nullptr;
    sm.position[slot] = next_group_;
    last_launch_ = std::max(now, next_group_ == 0 ? 0 : last_launch_ + 1);
    if (observer_ != nullptr) observer_->launched(s, slot, group, whole(last_launch_));
    launch_(last_launch_ + shared_.config.sm_links.message_latency, s, slot, group);
    turn_ = (s + 1) % sms;
    ++sm.launched;
    ++next_group_;
    ++running_;
  }
}

// As WorkDistributor: secondary rays start when all primary ones have ended.
bool Distributor::held_back(Cycle now) {
  if (secondary_) return false;
  if (acquired_ == nullptr) acquired_ = source_.acquire(next_group_);
  if (acquired_->kind == traces::RayKind::primary) return false;
  if (running_ > 0) return true;
  secondary_ = true;
  primary_end_ = now;
  return false;
}

void Distributor::ended(Cycle now, unsigned s, unsigned slot) {
  constexpr std::uint64_t kProgressGroups = 8;
  Sm& sm = sms_[s];
  const Cycle seen = now + shared_.config.sm_links.message_latency;
  if (observer_ != nullptr) observer_->ended(s, slot, whole(seen));
  source_.release(sm.position[slot]);
  end_ = std::max(end_, seen);
  sm.free_slots |= bit(slot);
  --running_;
  if (++ended_ % kProgressGroups == 0) progress_(ended_);
  launch(seen);
}

void Distributor::finish(Cycle now) {
  if (running_ > 0 || next_group_ < source_.count()) {
    throw std::runtime_error(fmt::format("deadlock in core cycle {}: nothing is due but {} warps run", now, running_));
  }
  if (!secondary_) primary_end_ = end_;
  progress_(ended_);
}

DistributorCounters Distributor::counters() const {
  DistributorCounters counters;
  counters.groups = next_group_;
  counters.most_on_one_sm = counters.fewest_on_one_sm = sms_.front().launched;
  for (const Sm& sm : sms_) {
    counters.most_on_one_sm = std::max(counters.most_on_one_sm, sm.launched);
    counters.fewest_on_one_sm = std::min(counters.fewest_on_one_sm, sm.launched);
  }
  counters.tail_cycles = whole(end_ - last_launch_);
  counters.primary_end = whole(primary_end_);
  return counters;
}

}  // namespace grtx::sim::fast
