// SPDX-License-Identifier: Apache-2.0
// Units of a user's own in the whole GPU: simulate() takes their factories, conservation and waveforms go on working.
#include <gtest/gtest.h>

#include <deque>
#include <memory>
#include <ostream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "grtx/modules/cache/l1_cache.h"
#include "grtx/modules/cache/l2_slice.h"
#include "grtx/modules/kernel/link_access.h"
#include "grtx/modules/noc/crossbar.h"
#include "grtx/modules/rt_unit/rt_unit.h"
#include "grtx/modules/simt/simt_core.h"
#include "grtx/modules/simt/work_distributor.h"
#include "rtl_tlm/observe/observed_run.h"

namespace grtx::sim {
namespace {

/// An L1 without storage: every request goes to the memory, one per cycle, and every answer comes back.
class NoCache final : public modules::L1CacheModule {
 public:
  NoCache(const sc_core::sc_module_name& name, const modules::L1Cache::Config& config, modules::ClockDomain& clock)
      : L1CacheModule(name, clock, config.clients), sm_(config.sm), answers_(config.clients) {}

  modules::L1Counters counters() const override { return counters_; }
  bool idle() const override { return outstanding_ == 0; }
  modules::Inventory inventory() const override { return {name(), {}, {}}; }
  void dump_state(std::ostream& out) const override { out << name() << ": " << outstanding_ << " outstanding\n"; }

 private:
  void end_of_elaboration() override {
    for (std::size_t c = 0; c < answers_.size(); ++c) {
      requests_.push_back(modules::reader_of(request[c]));
      requests_.back().wake(&alarm_);
      responses_.push_back(modules::writer_of(response[c]));
    }
    down_ = modules::writer_of(to_memory);
    up_ = modules::reader_of(from_memory);
    up_.wake(&alarm_);
  }
  Cycle tick(Cycle now) override {
    if (const modules::MemoryResponse* r = up_.front(now)) {
      answers_[r->client].push_back(*r);
      up_.pop(now);
    }
    for (std::size_t c = 0; c < answers_.size(); ++c) {
      if (answers_[c].empty() || !responses_[c].can_push(now)) continue;
      responses_[c].push(now, answers_[c].front());
      answers_[c].pop_front();
      --outstanding_;
      ++counters_.responses;
    }
    for (std::size_t i = 0; i < requests_.size(); ++i, turn_ = (turn_ + 1) % requests_.size()) {
      const modules::MemoryRequest* head = requests_[turn_].front(now);
      if (head == nullptr || !down_.can_push(now)) continue;
      modules::MemoryRequest down = *head;
      down.client = static_cast<std::uint8_t>(turn_);
      down.sm = sm_;
      down_.push(now, down);
      requests_[turn_].pop(now);
      ++outstanding_;
      auto& region = counters_.region[static_cast<std::size_t>(down.region)];
      if (down.prefetch) {
        ++counters_.prefetches;
        ++counters_.prefetches_fetched;
      } else {
        ++(down.write ? region.writes : region.reads);
        if (!down.write) ++region.misses;
      }
      ++(down.write ? counters_.sent_writes : counters_.sent_reads);
      if (!down.write) ++counters_.fills;
      break;
    }
    return outstanding_ > 0 || waiting(now) ? now + 1 : modules::kNever;
  }
  bool waiting(Cycle now) const {
    return std::any_of(requests_.begin(), requests_.end(), [&](const auto& r) { return r.front(now) != nullptr; });
  }

  std::uint8_t sm_;
  std::vector<modules::LinkReader<modules::MemoryRequest>> requests_;
  std::vector<modules::LinkWriter<modules::MemoryResponse>> responses_;
  modules::LinkWriter<modules::MemoryRequest> down_;
  modules::LinkReader<modules::MemoryResponse> up_;
  std::vector<std::deque<modules::MemoryResponse>> answers_;
  std::size_t turn_ = 0;
  std::uint64_t outstanding_ = 0;
  modules::L1Counters counters_;
};

TEST(OwnParts, AnL1OfTheUsersRunsTheWholeGpuAndConserves) {
  const test::ObservedRun run(true, true);
  const auto ours = run.run({});
  SimulationOptions options;
  options.build.parts.sm.l1_cache = [](const char* name, const modules::L1Cache::Config& config,
                                       modules::ClockDomain& clock) {
    return std::make_unique<NoCache>(name, config, clock);
  };
  options.waveform.path = run.path("own.vcd");
  options.timeline.path = run.path("own.json");
  const auto own = run.run(options);  // fails when a conservation law does not hold
  EXPECT_EQ(test::statistic(own, "gpu.rt.node_visits"), test::statistic(ours, "gpu.rt.node_visits"));
  EXPECT_GT(test::statistic(own, "gpu.l2.accesses"), test::statistic(ours, "gpu.l2.accesses")) << "nothing is cached";
  EXPECT_GT(test::statistic(own, "gpu.cycles"), test::statistic(ours, "gpu.cycles"));
}

TEST(OwnParts, ACrossbarOfTheUsersIsTheOneThatTheGpuHas) {
  const test::ObservedRun run(true, true);
  SimulationOptions options;
  options.build.parts.crossbar = [](const char* name, modules::Crossbar::Config config, modules::ClockDomain& clock) {
    config.latency += 100;
    return std::make_unique<modules::Crossbar>(name, config, clock);
  };
  EXPECT_GT(test::statistic(run.run(options), "gpu.cycles"), test::statistic(run.run({}), "gpu.cycles") + 100);
}

/// A trace and keys. Between them, a GPU has every unit that it can have.
struct Machine {
  bool two_level;
  bool procedural;
  std::vector<std::string> settings;
  bool delayed = false;
  bool rounds_only = false;  ///< no checkpoints
};

TEST(OwnParts, EveryFactoryIsCalledAndOneThatMakesNothingIsRefusedByName) {
  const std::vector<Machine> machines = {{true, false, {}},
                                         {false, true, {}},
                                         {true, false, {"rt.warp_buffer.spill=true", "rt.prefetch.enabled=true"}},
                                         {false, true, {"rt.gaussian.enabled=true", "rt.any_hit_unit.enabled=true"}},
                                         {false, true, {"rt.traversal=warp"}, false, true},
                                         {false, true, {}, true}};
  std::vector<std::unique_ptr<test::ObservedRun>> runs;
  for (const Machine& machine : machines) {
    runs.push_back(std::make_unique<test::ObservedRun>(!machine.delayed && !machine.rounds_only, machine.two_level, 0,
                                                       machine.procedural, false, machine.delayed));
  }
  GpuParts parts;
  for_each_factory(parts, [&](const char* name, const auto&) {
    SimulationOptions options;
    for_each_factory(options.build.parts, [name](const char* other, auto& factory) {
      if (std::string_view(name) == other) factory = [](auto&&...) { return nullptr; };
    });
    std::string refused;
    for (std::size_t i = 0; i < machines.size() && refused.empty(); ++i) {
      try {
        runs[i]->run(options, machines[i].settings);
      } catch (const Error& error) {
        refused = error.what();
      }
    }
    EXPECT_EQ(refused, std::string("parts: ") + name + ": its factory made nothing") << "nobody called it";
  });
}

TEST(OwnParts, OurOwnUnitsFromFactoriesGiveTheSameStatistics) {
  const test::ObservedRun run(true, true);
  SimulationOptions options;
  auto& parts = options.build.parts;
  parts.sm.l1_cache = [](const char* name, const modules::L1Cache::Config& config, modules::ClockDomain& clock) {
    return std::make_unique<modules::L1Cache>(name, config, clock);
  };
  parts.sm.simt_core = [](const char* name, modules::ClockDomain& clock, const modules::SimtCoreConfig& config,
                          const traces::Header& header, const modules::MemoryMap& map) {
    return std::make_unique<modules::SimtCore>(name, clock, config, header, map);
  };
  parts.sm.rt_unit = [](const char* name, const modules::RtUnitConfig& config, const traces::Header& header,
                        const modules::MemoryMap& map, modules::ClockDomain& clock, unsigned sm) {
    return std::make_unique<modules::RtUnit>(name, config, header, map, clock, sm);
  };
  parts.work_distributor = [](const char* name, modules::ClockDomain& clock,
                              const modules::WorkDistributorConfig& config, modules::GroupSource& source) {
    return std::make_unique<modules::WorkDistributor>(name, clock, config, source);
  };
  parts.crossbar = [](const char* name, const modules::Crossbar::Config& config, modules::ClockDomain& clock) {
    return std::make_unique<modules::Crossbar>(name, config, clock);
  };
  parts.l2_slice = [](const char* name, const modules::L2Slice::Config& config, modules::ClockDomain& clock) {
    return std::make_unique<modules::L2Slice>(name, config, clock);
  };
  auto ours = run.run({});
  auto own = run.run(options);
  for (auto* stats : {&ours, &own}) {
    for (auto it = stats->begin(); it != stats->end();)
      it = it.key().starts_with("host.") ? stats->erase(it) : std::next(it);
  }
  EXPECT_EQ(own, ours);
}

}  // namespace
}  // namespace grtx::sim
