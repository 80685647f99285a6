// SPDX-License-Identifier: Apache-2.0
// A unit of a user's that answers what nobody asked ends the run in one line that names the unit, not the trace.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <deque>
#include <functional>
#include <memory>
#include <ostream>
#include <utility>

#include "grtx/base/error.h"
#include "grtx/modules/cache/decide/replacement.h"
#include "grtx/modules/dram/decide/dram_scheduling.h"
#include "grtx/modules/rt_unit/scheduler/decide/warp_selection.h"
#include "grtx/modules/simt/decide/work_distribution.h"
#include "rtl_tlm/observe/observed_run.h"

namespace grtx::sim {
namespace {

using ::testing::MatchesRegex;

/// Answers every lane twice, or the next lane, too.
class Hasty final : public modules::IntersectionModule {
 public:
  Hasty(const sc_core::sc_module_name& name, modules::LaneId other) : IntersectionModule(name), other_(other) {}
  void enqueue(Cycle now, modules::LaneId id, unsigned) override {
    lanes_.push_back(id);
    due_ = now + 1;
  }
  void tick(Cycle now) override {
    const std::deque<modules::LaneId> lanes = std::exchange(lanes_, {});
    due_ = modules::kNever;
    for (const modules::LaneId id : lanes) {
      client->unit_result(now, id);
      client->unit_result(now, other_ == 0 ? id : other_);
    }
  }
  bool idle() const override { return lanes_.empty(); }
  std::uint64_t progress() const override { return 0; }
  modules::IntersectionCounters counters() const override { return {}; }
  modules::Inventory inventory() const override { return {name(), {}, {}}; }
  void dump_state(std::ostream& out) const override { out << name() << '\n'; }

 private:
  modules::LaneId other_;
  std::deque<modules::LaneId> lanes_;
};

std::string failure_of(const std::function<void(modules::RtUnitParts&)>& parts) {
  const test::ObservedRun run;
  ChildProcess child("simulation", [&]() -> std::string {
    SimulationOptions options;
    parts(options.build.parts.sm.rt_parts);
    try {
      simulate(run.path("t.grtx"), load_config(grtx::paths::source_dir() + "/configs/small.toml", {}), options);
    } catch (const Error& error) {
      return error.what();
    }
    return "none";
  });
  return child.result();
}

TEST(WrongAnswers, AreBlamedOnTheUnitThatGivesThem) {
  for (const modules::LaneId other : {modules::LaneId{0}, modules::LaneId{12345}}) {
    const auto with = [other](const char* name, const modules::RtUnitContext&) {
      return std::make_unique<Hasty>(name, other);
    };
    EXPECT_THAT(failure_of([&](modules::RtUnitParts& parts) { parts.ray_box = with; }),
                MatchesRegex("gpu\\.sm[0-9]+\\.rt\\.ray_box: .*at .*: has a result for lane [0-9]+, which asked for "
                             "none"));
    EXPECT_THAT(failure_of([&](modules::RtUnitParts& parts) { parts.ray_transform = with; }),
                MatchesRegex("gpu\\.sm[0-9]+\\.rt\\.ray_transform: .*: has a result for lane [0-9]+, which asked for "
                             "none"));
  }
}

/// Policies that answer nonsense.
struct Way4711 final : modules::CacheReplacement {
  void filled(std::uint64_t, unsigned, const modules::MemoryRequest&) override {}
  void referenced(std::uint64_t, unsigned, const modules::MemoryRequest&) override {}
  unsigned victim(std::uint64_t, const modules::MemoryRequest&) const override { return 4711; }
  unsigned bits_per_line() const override { return 0; }
};
struct Bank4711 final : modules::DramScheduling {
  modules::DramChoice choose(Cycle, const modules::DramQueues&) override { return {.row = 4711}; }
};
struct Entry4711 final : modules::WarpSelection {
  unsigned select(LaneMask, const std::vector<std::uint64_t>&, const modules::SelectableWarps&) override {
    return 4711;
  }
};

struct Sm4711 final : modules::WorkDistribution {
  unsigned choose(const traces::RayGroup&, const std::vector<unsigned>&) override { return 4711; }
};

/// Another dirty way whenever it is asked.
struct FickleWay final : modules::CacheReplacement {
  explicit FickleWay(unsigned ways) : ways_(ways) {}
  void filled(std::uint64_t, unsigned, const modules::MemoryRequest&) override {}
  void referenced(std::uint64_t, unsigned, const modules::MemoryRequest&) override {}
  unsigned victim(std::uint64_t, const modules::MemoryRequest&) const override { return asked_++ % ways_; }
  unsigned bits_per_line() const override { return 0; }

 private:
  unsigned ways_;
  mutable unsigned asked_ = 0;
};

std::string failure_with(const std::string& setting, const std::string& more = "l1.bytes=2048", bool walks = false) {
  const test::ObservedRun run(!walks, !walks);
  ChildProcess child("simulation", [&]() -> std::string {
    modules::register_cache_replacement("way_4711",
                                        [](std::uint64_t, unsigned) { return std::make_unique<Way4711>(); });
    modules::register_cache_replacement("fickle",
                                        [](std::uint64_t, unsigned ways) { return std::make_unique<FickleWay>(ways); });
    modules::register_cache_replacement("no_replacement", [](std::uint64_t, unsigned) { return nullptr; });
    modules::register_dram_scheduling("bank_4711",
                                      [](const modules::DramChannelConfig&) { return std::make_unique<Bank4711>(); });
    modules::register_warp_selection("entry_4711", [] { return std::make_unique<Entry4711>(); });
    modules::register_work_distribution("sm_4711", [](unsigned) { return std::make_unique<Sm4711>(); });
    register_memory_system("no_memory", [](Gpu&, const BuildOptions&) { return nullptr; });
    try {
      simulate(run.path("t.grtx"), load_config(grtx::paths::source_dir() + "/configs/small.toml", {setting, more}), {});
    } catch (const Error& error) {
      return error.what();
    } catch (const std::exception& error) {
      return std::string("internal error: ") + error.what();
    }
    return "none";
  });
  return child.result();
}

// Victim 4711 crashed, a factory of nothing meant lru, and a choice of the DRAM's was an internal error.
TEST(WrongAnswers, OfPoliciesAreNamedInOneLine) {
  EXPECT_THAT(failure_with("l1.replacement=way_4711"),
              MatchesRegex("gpu\\.sm[0-9]+\\.l1d: .*: the cache replacement way_4711 chose way 4711 of [0-9]+"));
  EXPECT_THAT(failure_with("l1.replacement=no_replacement"),
              MatchesRegex(".*the factory of the cache replacement no_replacement made nothing"));
  EXPECT_THAT(
      failure_with("dram.scheduling=bank_4711"),
      MatchesRegex("dram: .*: the DRAM scheduling bank_4711 chose a command that is not ready: row of bank 4711, "
                   "column of bank none"));
  EXPECT_THAT(failure_with("rt.scheduler.policy=entry_4711"),
              MatchesRegex("gpu\\.sm[0-9]+\\.rt: .*: the warp selection entry_4711 chose entry 4711, which is no "
                           "candidate"));
  EXPECT_THAT(failure_with("rt.scheduler.policy=entry_4711", "rt.traversal=warp", true),
              MatchesRegex("gpu\\.sm[0-9]+\\.rt: .*: the warp selection entry_4711 chose entry 4711, which is no "
                           "candidate"))
      << "it was a segmentation fault";
  EXPECT_THAT(failure_with("gpu.distribution=sm_4711"),
              MatchesRegex("gpu\\.distributor: .*: the work distribution sm_4711 chose SM 4711, which has no room"));
  EXPECT_EQ(failure_with("dram.model=no_memory"), "parts: no_memory: its factory made nothing");
}

// The cache asks twice: for room, and then for the way.
TEST(WrongAnswers, OfAReplacementThatChangesItsMindEndNoRun) {
  EXPECT_EQ(failure_with("l1.replacement=fickle", "l1.bytes=2048"), "none");
  EXPECT_EQ(failure_with("l2.replacement=fickle", "l2.bytes=8192"), "none");
}

}  // namespace
}  // namespace grtx::sim
