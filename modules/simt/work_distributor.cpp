// SPDX-License-Identifier: Apache-2.0
#include "grtx/modules/simt/work_distributor.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <ostream>
#include <string>

#include "grtx/base/error.h"
#include "grtx/modules/kernel/wrong_answer.h"
#include "grtx/modules/messages/lane_loop.h"
#include "grtx/modules/simt/decide/register_file.h"

namespace grtx::modules {
namespace {

constexpr LaneMask all_slots(unsigned slots) { return slots >= 64 ? ~LaneMask{0} : bit(slots) - 1; }

const WorkDistributorConfig& checked(const WorkDistributorConfig& config) {
  if (config.sms == 0) throw Error("configuration", "sms", "must be at least 1");
  check_resident_warps(config.resident_warps);
  return config;
}

}  // namespace

WorkDistributor::WorkDistributor(const sc_core::sc_module_name& name, ClockDomain& domain,
                                 const WorkDistributorConfig& config, GroupSource& source)
    : WorkDistributorModule(name, domain, checked(config).sms),
      config_(config),
      source_(source),
      done_("done"),
      sms_(config.sms),
      distribution_(make_work_distribution(config.distribution, config.sms)),
      room_(config.sms),
      groups_(source.count()),
      free_slots_(config.sms * config.resident_warps) {
  for (Sm& sm : sms_) {
    sm.free_slots = all_slots(config.resident_warps);
    sm.position.resize(config.resident_warps);
  }
  alarm_.request(0);  // the first launch
}

void WorkDistributor::start_of_simulation() {
  for (unsigned i = 0; i < config_.sms; ++i) {
    sms_[i].launch = writer_of(launch[i]);
    sms_[i].ended = reader_of(ended[i]);
    sms_[i].ended.wake(&alarm_);
  }
}

void WorkDistributor::restart(Caches) {
  for (Sm& sm : sms_) {
    sm.free_slots = all_slots(config_.resident_warps);
    sm.launched = 0;
  }
  free_slots_ = config_.sms * config_.resident_warps;
  running_ = 0;
  ready_ = nullptr;
  groups_ = source_.count();
  next_ = 0;
  distribution_ = make_work_distribution(config_.distribution, config_.sms);
  order_ = {};
  finished_ = false;
  first_launch_ = last_launch_ = end_cycle_ = 0;
  alarm_.request(0);
}

Cycle WorkDistributor::tick(Cycle now) {
  if (finished_) return kNever;
  collect(now);
  if (next_ < groups_ && free_slots_ > 0 && !held_back(now)) dispatch(now);
  if (next_ == groups_ && running_ == 0) {
    finish(now);
    return kNever;
  }
  Cycle due = next_ < groups_ && free_slots_ > 0 && !held_back(now) ? now + 1 : kNever;
  for (const Sm& sm : sms_) due = std::min(due, sm.ended.next_visible());
  return due;
}

// The first group of a launch must wait until the previous launch has ended; each WarpEnded wakes the distributor.
bool WorkDistributor::held_back(Cycle now) {
  if (ready_ == nullptr) ready_ = source_.acquire(next_);
  return order_.holds_back(*ready_, running_ > 0, now);
}

void WorkDistributor::collect(Cycle now) {
  for (Sm& sm : sms_) {
    for (const WarpEnded* end; (end = sm.ended.front(now)) != nullptr; sm.ended.pop(now)) {
      assert((sm.free_slots & bit(end->slot)) == 0);
      sm.free_slots |= bit(end->slot);
      ++free_slots_;
      --running_;
      if (observer_ != nullptr) observer_->ended(static_cast<unsigned>(&sm - sms_.data()), end->slot, now);
      source_.release(sm.position[end->slot]);
    }
  }
}

unsigned WorkDistributor::chosen_sm() const {
  const unsigned sm = distribution_->choose(*ready_, room_);
  if (sm != WorkDistribution::kNobody && (sm >= config_.sms || room_[sm] == 0)) {
    throw WrongAnswer("the work distribution " + config_.distribution + " chose SM " + std::to_string(sm) +
                      ", which has no room");
  }
  return sm;
}

void WorkDistributor::dispatch(Cycle now) {
  bool none = true;
  for (unsigned i = 0; i < config_.sms; ++i) {
    room_[i] = sms_[i].launch.can_push(now) ? static_cast<unsigned>(std::popcount(sms_[i].free_slots)) : 0;
    none = none && room_[i] == 0;
  }
  const unsigned index = none ? WorkDistribution::kNobody : chosen_sm();
  if (index == WorkDistribution::kNobody) return;
  Sm& sm = sms_[index];
  LaunchWarp warp;
  warp.slot = static_cast<std::uint16_t>(std::countr_zero(sm.free_slots));
  warp.group = ready_;
  ready_ = nullptr;
  sm.launch.push(now, warp);
  if (observer_ != nullptr) observer_->launched(index, warp.slot, *warp.group, now);
  sm.free_slots &= sm.free_slots - 1;
  sm.position[warp.slot] = next_;
  ++sm.launched;
  if (next_ == 0) first_launch_ = now;
  last_launch_ = now;
  ++next_;
  --free_slots_;
  ++running_;
}

void WorkDistributor::finish(Cycle now) {
  finished_ = true;
  end_cycle_ = now;
  order_.finish(now);
  done_.notify(sc_core::SC_ZERO_TIME);
}

DistributorCounters WorkDistributor::counters() const {
  DistributorCounters c;
  c.groups = next_;
  c.most_on_one_sm = c.fewest_on_one_sm = sms_.front().launched;
  for (const Sm& sm : sms_) {
    c.fewest_on_one_sm = std::min(c.fewest_on_one_sm, sm.launched);
    c.most_on_one_sm = std::max(c.most_on_one_sm, sm.launched);
  }
  c.tail_cycles = finished_ ? end_cycle_ - last_launch_ : 0;
  c.launches = order_.spans();
  return c;
}

void describe(const DistributorCounters& c, StatisticList& list, const std::string& prefix) {
  list.add(prefix + ".groups", c.groups, "groups", "ray groups handed to SMs", StatisticKind::exact);
  list.add(prefix + ".most_on_one_sm", c.most_on_one_sm, "groups", "ray groups of the SM that got most",
           StatisticKind::largest);
  list.add(prefix + ".fewest_on_one_sm", c.fewest_on_one_sm, "groups", "ray groups of the SM that got fewest",
           StatisticKind::smallest);
  list.add(prefix + ".tail_cycles", c.tail_cycles, "cycles",
           "cycles from the last launch to the end: no new work replaced finished warps", StatisticKind::state);
}

Inventory WorkDistributor::inventory() const {
  Inventory inventory;
  inventory.module = name();
  inventory.storage.push_back({"free_slots", StorageKind::flip_flop,
                               static_cast<std::uint64_t>(config_.sms) * config_.resident_warps, 1, 1, false});
  inventory.storage.push_back({"next_group", StorageKind::flip_flop, 32, 1, 1, false});
  inventory.operators.push_back({"int_add", 32, 1});
  return inventory;
}

void WorkDistributor::dump_state(std::ostream& out) const {
  out << name() << ": " << next_ << " of " << groups_ << " groups launched, " << running_ << " running\n";
  for (unsigned i = 0; i < config_.sms; ++i) {
    for_each_bit(all_slots(config_.resident_warps) & ~sms_[i].free_slots, [&](unsigned slot) {
      out << "  sm " << i << " slot " << slot << ": group at position " << sms_[i].position[slot] << "\n";
    });
  }
}

std::unique_ptr<WorkDistributorModule> make_work_distributor(const sc_core::sc_module_name& name, ClockDomain& domain,
                                                             const WorkDistributorConfig& config, GroupSource& source) {
  return std::make_unique<WorkDistributor>(name, domain, config, source);
}

}  // namespace grtx::modules
