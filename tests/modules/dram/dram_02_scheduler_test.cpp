// SPDX-License-Identifier: Apache-2.0
// DRAM channel scheduler: row hits first, then oldest first, with an age cap; lazy execution equals clock by clock.
#include <gtest/gtest.h>

#include "grtx/base/error.h"
#include "grtx/modules/dram/decide/dram_channel.h"
#include "modules/dram/dram_load.h"
#include "modules/memory_mocks.h"

namespace grtx::modules {
namespace {

struct Done {
  std::uint64_t id;
  Cycle done;
  bool operator==(const Done&) const = default;
};

std::vector<Done> drain(DramChannel& channel) {
  std::vector<Done> done;
  while (!channel.completions().empty()) {
    done.push_back({channel.completions().front().id, channel.completions().front().done});
    channel.completions().pop();
  }
  return done;
}

TEST(DramScheduler, RowHitsOvertakeAnOlderConflict) {
  DramChannel channel({});
  channel.enqueue(100, 0, 0, 32, false);
  channel.enqueue(100, 1, kSameBank, 32, false);
  channel.enqueue(100, 2, 32, 32, false);
  channel.enqueue(100, 3, 64, 32, false);
  channel.run_until(10000);
  const std::vector<Done> done = drain(channel);
  EXPECT_EQ(done[0].id, 0u);
  EXPECT_EQ(done[1].id, 2u);
  EXPECT_EQ(done[2].id, 3u);
  EXPECT_EQ(done[3].id, 1u);
  // RAS is over only after the hits: PRE at 100 + RAS.
  EXPECT_EQ(done[3].done, 100 + kTiming.ras + kTiming.rp + kTiming.rcd + kTiming.cl + kTiming.ccd);
}

TEST(DramScheduler, AReadyBankOvertakesABusyOne) {
  DramChannel channel({});
  channel.enqueue(100, 0, 0, 32, false);
  channel.run_until(999);
  channel.enqueue(1000, 1, kSameBank, 32, false);  // conflict
  channel.enqueue(1000, 2, 32 + kRow, 32, false);  // closed bank
  channel.run_until(10000);
  const std::vector<Done> done = drain(channel);
  EXPECT_EQ(done[1].id, 2u);
  EXPECT_EQ(done[1].done, 1001 + kTiming.rcd + kTiming.cl + kTiming.ccd)
      << "one row command per clock: PRE first, ACT next";
  EXPECT_EQ(done[2].done, 1000 + kTiming.rp + kTiming.rcd + kTiming.cl + kTiming.ccd);
}

// An endless stream of hits to one row against one older request of another row of the bank.
Cycle victims_latency(Cycle age_cap) {
  DramChannelConfig config{.age_cap = age_cap};
  DramChannel channel(config);
  channel.enqueue(100, 1, 0, 32, false);
  channel.enqueue(100, 0, kSameBank, 32, false);
  Cycle victim = 0;
  for (Cycle clock = 101; clock < 20000 && victim == 0; ++clock) {
    channel.run_until(clock - 1);
    if (channel.can_accept(32)) channel.enqueue(clock, 2, clock % 64 * 32, 32, false);
    for (const Done& done : drain(channel)) {
      if (done.id == 0) victim = done.done;
    }
  }
  return victim == 0 ? kNever : victim - 100;
}

TEST(DramScheduler, NothingStarves) {
  EXPECT_EQ(victims_latency(Cycle{1'000'000'000'000}), kNever) << "without a cap the stream of hits goes on for ever";
  for (const Cycle cap : {64u, 256u, 1024u}) {
    // Once aged: the bank precharges, activates and reads, after the last read's RTP; the bus waits for nobody else.
    const Cycle latency = victims_latency(cap);
    EXPECT_GE(latency, cap);
    EXPECT_LE(latency, cap + 1 + kTiming.rtp + kTiming.rp + kTiming.rcd + kTiming.ccd + kTiming.cl + kTiming.ccd)
        << "cap " << cap;
  }
}

TEST(DramScheduler, AnAgedWriteStopsTheReadsOfOtherBanks) {
  // Reads keep the bus busy, so a write never gets its turnaround until it has aged.
  DramChannelConfig config{.age_cap = 300};
  DramChannel channel(config);
  Cycle victim = 0;
  for (Cycle clock = 100; clock < 5000; ++clock) {
    channel.run_until(clock - 1);
    if (clock == 400) channel.enqueue(clock, 0, 64, 32, true);
    // One place stays free for the write.
    if (channel.can_accept(64)) channel.enqueue(clock, 2, (clock % 2) * kRow + clock % 64 * 32, 32, false);
    for (const Done& done : drain(channel)) {
      if (done.id == 0) victim = done.done;
    }
  }
  ASSERT_NE(victim, 0u);
  // Older reads go before it, at most a queue of them, which have aged too; then the turnaround.
  EXPECT_GT(victim, 400 + 300u);
  EXPECT_LE(victim, 400 + 301 + kTiming.read_to_write() + kTiming.wl + kTiming.ccd);
  EXPECT_GE(channel.counters().aged, 1u);
}

TEST(DramScheduler, LazyExecutionEqualsClockByClock) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    DramChannelConfig config{.queue = 24, .age_cap = 150, .bank_xor = seed % 2 == 0};
    if (seed % 3 == 0) {
      config.bank_groups = 4;
      config.timing.ccd_l = 6;
      config.timing.faw = 50;
      config.timing.refi = 900;
      config.timing.rfc = 120;
    }
    DramChannel lazy(config);
    DramChannel eager(config);
    Random random(seed);
    std::vector<Done> lazily;
    std::vector<Done> eagerly;
    Cycle clock = 10;
    Cycle eager_clock = 0;
    for (std::uint64_t id = 0; id < 3000; ++id) {
      const std::uint64_t address = (random.below(8) * 16 + random.below(6)) * kRow + random.below(16) * 128;
      const unsigned bytes = random.chance(10) ? 128 : 32;
      const bool write = random.chance(30);
      clock += random.below(random.chance(5) ? 400 : 12);
      if (lazy.run_until(clock - 1); !lazy.can_accept(bytes)) clock = lazy.run_until_room(bytes) + 1;
      for (; eager_clock < clock; ++eager_clock) eager.step(eager_clock);
      ASSERT_TRUE(eager.can_accept(bytes));
      lazy.enqueue(clock, id, address, bytes, write);
      eager.enqueue(clock, id, address, bytes, write);
    }
    lazy.run_until(1'000'000);
    for (; eager_clock < 300'000; ++eager_clock) eager.step(eager_clock);
    for (const Done& d : drain(lazy)) lazily.push_back(d);
    for (const Done& d : drain(eager)) eagerly.push_back(d);
    EXPECT_EQ(lazily, eagerly);
    EXPECT_EQ(lazily.size(), 3000u);
    EXPECT_EQ(lazy.counters().queue_clocks, eager.counters().queue_clocks);
    EXPECT_EQ(lazy.counters().row_conflicts, eager.counters().row_conflicts);
    EXPECT_EQ(lazy.counters().refreshes, eager.counters().refreshes);
    EXPECT_GT(lazy.counters().aged, 0u);
    EXPECT_TRUE(std::is_sorted(lazily.begin(), lazily.end(), [](auto& a, auto& b) { return a.done < b.done; }));
  }
}

TEST(DramScheduler, TimingRulesHoldForEveryPairOfDataBursts) {
  // The data bus: no two bursts closer than CCD, whatever the traffic.
  DramChannel channel({});
  Random random(3);
  Cycle clock = 10;
  Cycle last = 0;
  for (std::uint64_t id = 0; id < 5000; ++id) {
    if (channel.run_until(clock - 1); !channel.can_accept(32)) clock = channel.run_until_room(32) + 1;
    channel.enqueue(clock, id, random.below(4096) * 512, 32, random.chance(30));
    for (const Done& done : drain(channel)) {
      EXPECT_GE(done.done, last + kTiming.ccd);
      last = done.done;
    }
    clock += random.below(3);
  }
}

TEST(DramScheduler, ImpossibleConfigurationsAreRefused) {
  DramChannelConfig config{.banks = 65};
  EXPECT_THROW(DramChannel{config}, Error);
  config = {};
  config.banks = 12;
  config.bank_xor = true;
  EXPECT_THROW(DramChannel{config}, Error);
  config = {};
  config.queue = 1;
  EXPECT_THROW(DramChannel{config}, Error);
  config = {};
  config.bank_groups = 3;  // of 16 banks
  EXPECT_THROW(DramChannel{config}, Error);
  for (const unsigned bytes : {96u, 4096u, 16u}) {
    config = {};
    config.bank_groups = 4;
    config.group_bytes = bytes;
    EXPECT_THROW(DramChannel{config}, Error) << bytes;
  }
  config = {};
  config.timing.rfc = 300;
  config.timing.refi = 300 + config.timing.rc + config.timing.rp + config.timing.rcd;
  DramChannel{config};
  --config.timing.refi;
  EXPECT_THROW(DramChannel{config}, Error);
}

}  // namespace
}  // namespace grtx::modules
