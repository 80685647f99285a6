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
    sm.free_slots = lowest_bits(shared.config.resident());
    sm.position.resize(shared.config.resident());
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
    const traces::RayGroup& group = *acquired_;
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

bool Distributor::held_back(Cycle now) {
  if (acquired_ == nullptr) acquired_ = source_.acquire(next_group_);
  return order_.holds_back(*acquired_, running_ > 0, now);
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
  order_.finish(end_);
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
  counters.launches = order_.spans();
  for (LaunchSpan& launch : counters.launches) launch.end = whole(launch.end);
  return counters;
}

}  // namespace grtx::sim::fast
