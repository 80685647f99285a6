// SPDX-License-Identifier: Apache-2.0
// The work distributor: index order, round robin over SMs, one launch per cycle, slot reuse, the end.
#include "grtx/modules/simt/work_distributor.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <deque>
#include <map>
#include <memory>
#include <string>

#include "grtx/base/error.h"
#include "modules/systemc_fixture.h"

namespace grtx::modules {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

class ListSource final : public GroupSource {
 public:
  explicit ListSource(std::size_t n) : groups_(n) {
    for (std::size_t i = 0; i < n; ++i) groups_[i].index = static_cast<std::uint32_t>(i);
  }
  std::uint64_t count() const override { return groups_.size(); }
  const traces::RayGroup* acquire(std::uint64_t position) override {
    acquired.push_back(position);
    return &groups_.at(position);
  }
  void release(std::uint64_t position) override { released.push_back(position); }

  void make_secondary(std::size_t first) { make_secondary(first, groups_.size()); }
  void make_secondary(std::size_t first, std::size_t end) {
    for (std::size_t i = first; i < end; ++i) groups_[i].kind = traces::RayKind::glass;
  }
  void make_frame(std::size_t first, std::size_t end, std::uint32_t frame) {
    for (std::size_t i = first; i < end; ++i) groups_[i].frame = frame;
  }

  std::vector<std::uint64_t> acquired;
  std::vector<std::uint64_t> released;

 private:
  std::vector<traces::RayGroup> groups_;
};

/// SMs that run each group for a time given by its index.
class WorkBench {
 public:
  struct Seen {
    Cycle cycle;
    unsigned sm;
    unsigned slot;
    std::uint32_t group;
    friend bool operator==(const Seen&, const Seen&) = default;
  };

  WorkBench(std::size_t groups, unsigned sms, unsigned slots, std::function<Cycle(std::uint32_t)> duration,
            const std::string& policy = "round_robin")
      : source(groups), clock("clock", 1365.0), distributor("distributor", clock, {sms, slots, policy}, source) {
    for (unsigned sm = 0; sm < sms; ++sm) {
      launches.emplace_back(std::make_unique<Link<LaunchWarp>>("launch" + std::to_string(sm), 1, slots));
      ends.emplace_back(std::make_unique<Link<WarpEnded>>("ended" + std::to_string(sm), 1, slots));
      distributor.launch[sm].bind(*launches[sm]);
      distributor.ended[sm].bind(*ends[sm]);
    }
    process = std::make_unique<TickProcess>("sms", clock, [this, sms, duration](Cycle now) {
      for (unsigned sm = 0; sm < sms; ++sm) {
        while (const LaunchWarp* warp = launches[sm]->front(now)) {
          seen.push_back({now, sm, warp->slot, warp->group->index});
          const Cycle end = now + duration(warp->group->index);
          running[end].push_back({sm, warp->slot});
          clock.request(end);
          launches[sm]->pop(now);
        }
      }
      if (const auto due = running.find(now); due != running.end()) {
        for (const auto& [sm, slot] : due->second) {
          ends[sm]->push(now, WarpEnded{static_cast<std::uint16_t>(slot)});
          clock.request(now + 1);
        }
        running.erase(due);
      }
    });
    for (const auto& launch : launches) process->watch(*launch);
  }

  ListSource source;
  ClockDomain clock;
  WorkDistributor distributor;
  std::vector<std::unique_ptr<Link<LaunchWarp>>> launches;
  std::vector<std::unique_ptr<Link<WarpEnded>>> ends;
  std::unique_ptr<TickProcess> process;
  std::map<Cycle, std::vector<std::pair<unsigned, unsigned>>> running;
  std::vector<Seen> seen;
};

class WorkDistributorTest : public SystemCTest {};

TEST_F(WorkDistributorTest, AnSmHasAtMost64Slots) {
  EXPECT_THROW(WorkBench(1, 1, 65, [](std::uint32_t) { return 1; }), Error);
}

TEST_F(WorkDistributorTest, OneGroupACycleRoundRobinLowestFreeSlot) {
  WorkBench bench(6, 2, 3, [](std::uint32_t) { return 1000; });
  EXPECT_TRUE(run_until_quiet(bench.clock, 10000));
  using S = WorkBench::Seen;
  EXPECT_THAT(bench.seen,
              ElementsAre(S{1, 0, 0, 0}, S{2, 1, 0, 1}, S{3, 0, 1, 2}, S{4, 1, 1, 3}, S{5, 0, 2, 4}, S{6, 1, 2, 5}));
}

/// All to the last SM; while that is full the group waits.
struct LastOnly final : WorkDistribution {
  unsigned choose(const traces::RayGroup&, const std::vector<unsigned>& room) override {
    return room.back() != 0 ? static_cast<unsigned>(room.size()) - 1 : kNobody;
  }
};

TEST_F(WorkDistributorTest, APolicyOfTheUsersMayLetAGroupWait) {
  register_work_distribution("last_only", [](unsigned) { return std::make_unique<LastOnly>(); });
  WorkBench bench(
      3, 2, 2, [](std::uint32_t) { return 10; }, "last_only");
  EXPECT_TRUE(run_until_quiet(bench.clock, 10000));
  using S = WorkBench::Seen;
  // Group 0 ends in 11, which is seen in 12; group 2 starts in 13.
  EXPECT_THAT(bench.seen, ElementsAre(S{1, 1, 0, 0}, S{2, 1, 1, 1}, S{13, 1, 0, 2}));
  EXPECT_EQ(work_distribution_names(), (std::vector<std::string>{"round_robin", "last_only"}));
}

TEST_F(WorkDistributorTest, AFreedSlotIsReusedTheCycleItsEndIsSeen) {
  // One SM, two slots; group 0 takes 10 cycles, the others 100.
  WorkBench bench(4, 1, 2, [](std::uint32_t g) { return g == 0 ? Cycle{10} : Cycle{100}; });
  EXPECT_TRUE(run_until_quiet(bench.clock, 10000));
  using S = WorkBench::Seen;
  // Group 0: seen in 1, ends in 11, its end is seen in 12, group 2 starts in 13 in the same slot. Group 1 ends in 102.
  EXPECT_THAT(bench.seen, ElementsAre(S{1, 0, 0, 0}, S{2, 0, 1, 1}, S{13, 0, 0, 2}, S{104, 0, 1, 3}));
  EXPECT_THAT(bench.source.released, ElementsAre(0, 1, 2, 3));
  EXPECT_TRUE(bench.distributor.finished());
  EXPECT_EQ(bench.distributor.end_cycle(), 205u);  // group 3 ends in 204
}

TEST_F(WorkDistributorTest, SecondaryGroupsWaitForTheLastPrimaryOne) {
  // Slots are free all the time, yet groups 3 and 4 start only when the longest of 0 to 2 has ended.
  WorkBench bench(5, 2, 4, [](std::uint32_t g) { return g == 1 ? Cycle{300} : Cycle{20}; });
  bench.source.make_secondary(3);
  EXPECT_TRUE(run_until_quiet(bench.clock, 10000));
  using S = WorkBench::Seen;
  // Group 1: seen in 2, ends in 302, its end is seen in 303; group 3 is launched then and seen in 304.
  EXPECT_THAT(bench.seen, ElementsAre(S{1, 0, 0, 0}, S{2, 1, 0, 1}, S{3, 0, 1, 2}, S{304, 1, 0, 3}, S{305, 0, 0, 4}));
  EXPECT_EQ(bench.distributor.counters().launches, (std::vector<LaunchSpan>{{0, false, 303}, {0, true, 326}}));
  EXPECT_EQ(bench.distributor.end_cycle(), 326u);  // group 4 ends in 325
  EXPECT_THAT(bench.source.acquired, ElementsAre(0, 1, 2, 3, 4));
}

TEST_F(WorkDistributorTest, AFrameWaitsForTheFrameBefore) {
  // Frames of groups 0 and 1, 2 and 3 (secondary), 4: three launches and a fourth.
  WorkBench bench(5, 2, 4, [](std::uint32_t g) { return g == 1 ? Cycle{300} : Cycle{20}; });
  bench.source.make_secondary(3, 4);
  bench.source.make_frame(2, 4, 1);
  bench.source.make_frame(4, 5, 2);
  EXPECT_TRUE(run_until_quiet(bench.clock, 10000));
  using S = WorkBench::Seen;
  // As above: group 2 is seen in 304 and ends in 324, which is seen in 325; each launch takes 22 cycles from then on.
  EXPECT_THAT(bench.seen, ElementsAre(S{1, 0, 0, 0}, S{2, 1, 0, 1}, S{304, 0, 0, 2}, S{326, 1, 0, 3}, S{348, 0, 0, 4}));
  const std::vector<LaunchSpan> launches = bench.distributor.counters().launches;
  EXPECT_EQ(launches, (std::vector<LaunchSpan>{{0, false, 303}, {1, false, 325}, {1, true, 347}, {2, false, 369}}));
  EXPECT_EQ(cycles_of_kind(launches, true), 22u);
  EXPECT_EQ(cycles_of_kind(launches, false), 347u);
}

TEST_F(WorkDistributorTest, SkipsFullSmsAndKeepsIndexOrder) {
  // SM 0 is held by long groups (even indices at first); later groups all go to SM 1.
  WorkBench bench(10, 2, 1, [](std::uint32_t g) { return g == 0 ? Cycle{500} : Cycle{20}; });
  EXPECT_TRUE(run_until_quiet(bench.clock, 10000));
  ASSERT_EQ(bench.seen.size(), 10u);
  for (std::uint32_t g = 0; g < 10; ++g) {
    EXPECT_EQ(bench.seen[g].group, g);
    EXPECT_EQ(bench.seen[g].sm, g == 0 ? 0u : 1u);
  }
  EXPECT_EQ(bench.distributor.launched_on(0), 1u);
  EXPECT_EQ(bench.distributor.launched_on(1), 9u);
  EXPECT_EQ(bench.source.released.size(), 10u);
}

TEST_F(WorkDistributorTest, FiresDoneOnceWhenTheLastGroupEnded) {
  WorkBench bench(3, 2, 2, [](std::uint32_t) { return 50; });
  unsigned fired = 0;
  class Listener final : public sc_core::sc_module {
   public:
    using SC_CURRENT_USER_MODULE [[maybe_unused]] = Listener;  // SC_HAS_PROCESS, which SystemC 3 deprecates
    Listener(const sc_core::sc_module_name& name, const sc_core::sc_event& event, unsigned& count)
        : sc_module(name), count_(count) {
      SC_METHOD(on_done);
      sensitive << event;
      dont_initialize();
    }

   private:
    void on_done() { ++count_; }
    unsigned& count_;
  } listener("listener", bench.distributor.done(), fired);
  run(bench.clock, 52);  // the last group is seen in 3 and ends in 53
  EXPECT_EQ(fired, 0u);
  EXPECT_TRUE(run_until_quiet(bench.clock, 1000));
  EXPECT_EQ(fired, 1u);
  EXPECT_EQ(bench.distributor.end_cycle(), 54u);
  EXPECT_TRUE(bench.distributor.idle());
}

TEST_F(WorkDistributorTest, ATraceWithoutGroupsEndsAtOnce) {
  WorkBench bench(0, 2, 2, [](std::uint32_t) { return 5; });
  EXPECT_TRUE(run_until_quiet(bench.clock, 100));
  EXPECT_TRUE(bench.distributor.finished());
  EXPECT_EQ(bench.distributor.end_cycle(), 0u);
  EXPECT_THAT(bench.source.acquired, IsEmpty());
}

TEST_F(WorkDistributorTest, HoldsNoMoreGroupsThanThereAreSlots) {
  WorkBench bench(200, 3, 4, [](std::uint32_t g) { return Cycle{1} + (g * 7919U) % 97; });
  std::size_t most = 0;
  TickProcess watch("watch", bench.clock,
                    [&](Cycle) { most = std::max(most, bench.source.acquired.size() - bench.source.released.size()); });
  EXPECT_TRUE(run_until_quiet(bench.clock, 100000));
  EXPECT_EQ(bench.source.acquired.size(), 200u);
  EXPECT_TRUE(std::is_sorted(bench.source.acquired.begin(), bench.source.acquired.end()));
  EXPECT_EQ(bench.source.released.size(), 200u);
  EXPECT_LE(most, 12u);
}

}  // namespace
}  // namespace grtx::modules
