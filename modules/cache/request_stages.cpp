// SPDX-License-Identifier: Apache-2.0
#include "grtx/modules/cache/request_stages.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

namespace grtx::modules {
namespace {

constexpr std::size_t at(MemoryStage stage) { return static_cast<std::size_t>(stage); }

}  // namespace

ReadKind read_kind(Region region) {
  switch (region) {
    case Region::tlas:
    case Region::blas:
      return ReadKind::nodes;
    case Region::leaf:
    case Region::instance:
      return ReadKind::leaves;
    case Region::checkpoint:
      return ReadKind::checkpoints;
    case Region::stack:
      return ReadKind::stacks;
    case Region::eviction:
    case Region::k_buffer:
    case Region::gaussian:
    case Region::sh:
    case Region::ray:
      break;
  }
  return ReadKind::shading;
}

void StageCycles::add(std::uint64_t cycles) {
  if (bins_.empty()) bins_.resize(kBins + 1);
  ++count_;
  sum_ += cycles;
  largest_ = std::max(largest_, cycles);
  ++bins_[std::min<std::uint64_t>(cycles, kBins)];
}

double StageCycles::mean() const { return declare::ratio(sum_, count_); }

std::uint64_t StageCycles::percentile(double share) const {
  const auto wanted = static_cast<std::uint64_t>(std::ceil(share * static_cast<double>(count_)));
  std::uint64_t below = 0;
  for (std::size_t cycles = 0; cycles < bins_.size(); ++cycles) {
    below += bins_[cycles];
    if (below >= wanted) return cycles == kBins ? largest_ : cycles;
  }
  return 0;
}

inline RequestStages::Miss& RequestStages::miss(unsigned sm, std::uint32_t mshr) {
  if (sm >= misses_.size()) misses_.resize(sm + 1);
  std::vector<Miss>& of_sm = misses_[sm];
  if (mshr >= of_sm.size()) of_sm.resize(mshr + 1);
  return of_sm[mshr];
}

void RequestStages::waits(unsigned sm, std::uint32_t mshr, Cycle asked, Cycle accepted, bool first) {
  Miss& of = miss(sm, mshr);
  if (first) {
    of.waiters.clear();
    of.allocated = accepted;
    of.left = of.entered = of.missed = of.filled = of.replied = 0;
  }
  of.waiters.push_back({asked, accepted});
}

ServedRead RequestStages::fills_l1(unsigned sm, std::uint32_t mshr, std::size_t waiter, Cycle now) {
  const Miss& of = miss(sm, mshr);
  const Waiter& own = of.waiters.at(waiter);
  ServedRead read{own.asked, now, {}};
  read.cycles[at(MemoryStage::queue)] = static_cast<std::uint32_t>(own.accepted - own.asked);
  Cycle from = own.accepted;  // one that was merged meets what is left of the miss
  const auto pass = [&](MemoryStage stage, Cycle until) {
    if (until <= from) return;
    read.cycles[at(stage)] += static_cast<std::uint32_t>(until - from);
    from = until;
  };
  pass(MemoryStage::l1, of.left);
  if (of.entered == 0) {  // an L2 of somebody else, which says nothing
    pass(MemoryStage::l2, now);
    return read;
  }
  pass(MemoryStage::crossbar, of.entered);
  pass(MemoryStage::l2, of.missed);
  pass(MemoryStage::dram, of.filled);
  pass(MemoryStage::l2, of.replied);
  pass(MemoryStage::crossbar, now);
  return read;
}

void RequestStages::served(Region region, ServedRead read, Cycle now) {
  read.cycles[at(MemoryStage::l1)] += static_cast<std::uint32_t>(now - read.since);
  Reads& reads = reads_[static_cast<std::size_t>(read_kind(region))];
  reads.whole.add(now - read.asked);
  for (std::size_t stage = 0; stage < kStages; ++stage) reads.stages[stage].add(read.cycles[stage]);
}

void RequestStages::describe(StatisticList& list) const {
  for (std::size_t kind = 0; kind < kReadKinds; ++kind) {
    const Reads& reads = reads_[kind];
    if (reads.whole.count() == 0) continue;
    const std::string_view of = name_at<ReadKind>(kind);
    const std::string prefix = fmt::format("gpu.latency.{}", of);
    list.add(prefix + ".reads", reads.whole.count(), "reads", fmt::format("reads of 32 B for {}", of),
             StatisticKind::count);
    const auto add = [&](const std::string& name, const StageCycles& cycles, const std::string& where) {
      list.add(prefix + name, Quotient{cycles.sum(), cycles.count(), "", ""}, "cycles",
               fmt::format("mean time of a read for {} {}", of, where), StatisticKind::mean);
      list.add(prefix + name + "_p95", cycles.percentile(0.95), "cycles",
               fmt::format("95 % of the reads for {} spend no more {}", of, where), StatisticKind::state);
    };
    add(".whole", reads.whole, "from the requester's port and back");
    const char* const where[kStages] = {"before the L1 takes it", "in the L1", "in the crossbar, both ways",
                                        "in the L2", "in DRAM, from the L2 miss until its fill"};
    for (std::size_t stage = 0; stage < kStages; ++stage) {
      add(fmt::format(".{}", name_at<MemoryStage>(stage)), reads.stages[stage], where[stage]);
    }
  }
}

std::string RequestStages::violation() const {
  for (std::size_t kind = 0; kind < kReadKinds; ++kind) {
    std::uint64_t parts = 0;
    for (const StageCycles& stage : reads_[kind].stages) parts += stage.sum();
    if (parts == reads_[kind].whole.sum()) continue;
    return fmt::format("reads for {} take {} cycles, their stages {}", name_at<ReadKind>(kind),
                       reads_[kind].whole.sum(), parts);
  }
  return "";
}

}  // namespace grtx::modules
