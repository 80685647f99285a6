// SPDX-License-Identifier: Apache-2.0
// DRAM channel: exact clocks of row hits, misses and conflicts, of turnarounds and of the four-bank pipeline.
#include <gtest/gtest.h>

#include "grtx/modules/dram/decide/dram_channel.h"
#include "modules/dram/dram_load.h"

namespace grtx::modules {
namespace {

struct Request {
  Cycle at;
  std::uint64_t address;
  bool write = false;
  unsigned bytes = 32;
};

/// Clock of the end of data of each request, by id = position.
std::vector<Cycle> run(const std::vector<Request>& requests, DramChannelConfig config = {}) {
  DramChannel channel(config);
  for (std::size_t i = 0; i < requests.size(); ++i) {
    channel.run_until(requests[i].at - 1);
    channel.enqueue(requests[i].at, i, requests[i].address, requests[i].bytes, requests[i].write);
  }
  channel.run_until(1'000'000);
  std::vector<Cycle> done(requests.size(), 0);
  while (!channel.completions().empty()) {
    done[channel.completions().front().id] = channel.completions().front().done;
    channel.completions().pop();
  }
  EXPECT_TRUE(channel.idle());
  return done;
}

TEST(DramChannelTiming, ClosedRowHitAndConflict) {
  const Cycle idle = kTiming.rcd + kTiming.cl + kTiming.ccd;  // ACT, RD, data
  EXPECT_EQ(idle, 44u);
  EXPECT_EQ(run({{100, 0}})[0], 100 + idle);
  // The row stays open: a later request of the row needs the read only.
  EXPECT_EQ(run({{100, 0}, {1000, 64}})[1], 1000 + kTiming.cl + kTiming.ccd);
  // Another row of the bank: PRE, ACT, RD.
  EXPECT_EQ(run({{100, 0}, {1000, kSameBank}})[1], 1000 + kTiming.rp + idle);
  // Another bank is closed.
  EXPECT_EQ(run({{100, 0}, {1000, kRow}})[1], 1000 + idle);
}

TEST(DramChannelTiming, AnEarlyConflictWaitsForRas) {
  // ACT at 100; PRE not before 100 + RAS; ACT not before 100 + max(RAS + RP, RC).
  EXPECT_EQ(run({{100, 0}, {101, kSameBank}})[1],
            100 + kTiming.ras + kTiming.rp + kTiming.rcd + kTiming.cl + kTiming.ccd);
  DramChannelConfig slow_rc;
  slow_rc.timing.rc = 90;
  EXPECT_EQ(run({{100, 0}, {101, kSameBank}}, slow_rc)[1], 100 + 90 + kTiming.rcd + kTiming.cl + kTiming.ccd);
}

TEST(DramChannelTiming, Writes) {
  EXPECT_EQ(run({{100, 0, true}})[0], 100 + kTiming.rcd + kTiming.wl + kTiming.ccd);
  // Write to read of the same row: WL + burst + CDLR between the commands.
  EXPECT_EQ(run({{100, 0, true}, {101, 32}})[1],
            100 + kTiming.rcd + (kTiming.wl + kTiming.ccd + kTiming.cdlr) + kTiming.cl + kTiming.ccd);
  // Read to write: CL + burst + 2 - WL between the commands.
  EXPECT_EQ(run({{100, 0}, {101, 32, true}})[1],
            100 + kTiming.rcd + (kTiming.cl + kTiming.ccd + 2 - kTiming.wl) + kTiming.wl + kTiming.ccd);
  // A conflict after a write: precharge not before WR = 20 clocks after the last data, here later than RAS.
  EXPECT_EQ(run({{100, 0, true}, {101, kSameBank}})[1], 100 + kTiming.rcd + (kTiming.wl + kTiming.ccd + kTiming.wr) +
                                                            kTiming.rp + kTiming.rcd + kTiming.cl + kTiming.ccd);
}

TEST(DramChannelTiming, RowHitsStreamOneBurstEveryCcd) {
  std::vector<Request> requests;
  for (unsigned i = 0; i < 32; ++i) requests.push_back({100, i * 32});
  const std::vector<Cycle> done = run(requests);
  for (unsigned i = 0; i < 32; ++i) EXPECT_EQ(done[i], 100 + kTiming.rcd + i * kTiming.ccd + kTiming.cl + kTiming.ccd);
}

TEST(DramChannelTiming, BanksActivateRrdApart) {
  std::vector<Request> requests;
  for (unsigned i = 0; i < 16; ++i) requests.push_back({100, i * kRow});
  const std::vector<Cycle> done = run(requests);
  for (unsigned i = 0; i < 16; ++i) EXPECT_EQ(done[i], 100 + i * kTiming.rrd + kTiming.rcd + kTiming.cl + kTiming.ccd);
}

TEST(DramChannelTiming, ALineIsFourBursts) {
  EXPECT_EQ(run({{100, 0, false, 128}})[0], 100 + kTiming.rcd + 3 * kTiming.ccd + kTiming.cl + kTiming.ccd);
  EXPECT_EQ(run({{100, 0, false, 8}})[0], 100 + kTiming.rcd + kTiming.cl + kTiming.ccd)
      << "less than a burst takes a burst";
}

/// Four groups; the next block of a row is 128 B on and in the next group, the next bank of a group 8 KB on.
DramChannelConfig grouped() {
  DramChannelConfig config{.bank_groups = 4, .group_bytes = 128};
  config.timing.ccd_l = 7;
  config.timing.rrd_l = 14;
  config.timing.cdlr_l = 15;
  return config;
}
constexpr std::uint64_t kNextGroup = 128;
constexpr std::uint64_t kSameGroup = 4 * kRow;

TEST(DramChannelTiming, ABankGroupTakesAColumnCommandEveryCcdL) {
  // Rows are open in 1000. The third read could follow the first after CCD_L, but the second has the bus until then.
  const auto done = run({{100, 0}, {100, kNextGroup}, {1000, 32}, {1000, 64}, {1000, kNextGroup + 32}}, grouped());
  EXPECT_EQ(done[2], 1000 + kTiming.cl + kTiming.ccd);
  EXPECT_EQ(done[4], done[2] + kTiming.ccd) << "another group goes in between";
  EXPECT_EQ(done[3], done[4] + kTiming.ccd) << "8 clocks after the first, CCD_L is 7";
  EXPECT_EQ(run({{100, 0}, {1000, 32}, {1000, 64}}, grouped())[2], 1000 + 7 + kTiming.cl + kTiming.ccd);
  EXPECT_EQ(run({{100, 0, true}, {1000, 32, true}, {1000, 64, true}}, grouped())[2],
            1000 + 7 + kTiming.wl + kTiming.ccd);
}

TEST(DramChannelTiming, ABankGroupIsActivatedEveryRrdL) {
  const Cycle idle = kTiming.rcd + kTiming.cl + kTiming.ccd;
  EXPECT_EQ(run({{100, 0}, {100, kNextGroup}}, grouped())[1], 100 + kTiming.rrd + idle);
  EXPECT_EQ(run({{100, 0}, {100, kSameGroup}}, grouped())[1], 100 + 14 + idle);
}

TEST(DramChannelTiming, AWriteHoldsBackReadsOfItsBankGroupLonger) {
  const Cycle write = 1000 + kTiming.wl + kTiming.ccd;
  EXPECT_EQ(run({{100, 0}, {1000, 32, true}, {1001, 64}}, grouped())[2], write + 15 + kTiming.cl + kTiming.ccd);
  EXPECT_EQ(run({{100, kNextGroup}, {200, 0}, {1000, 32, true}, {1001, kNextGroup}}, grouped())[3],
            write + kTiming.cdlr + kTiming.cl + kTiming.ccd);
}

TEST(DramChannelTiming, WritesFollowAnActivateAfterATimeOfTheirOwn) {
  DramChannelConfig config;
  config.timing.rcd_wr = 13;
  EXPECT_EQ(run({{100, 0, true}}, config)[0], 100 + 13 + kTiming.wl + kTiming.ccd);
  EXPECT_EQ(run({{100, 0}}, config)[0], 100 + kTiming.rcd + kTiming.cl + kTiming.ccd);
}

TEST(DramChannelTiming, FourActivatesAWindow) {
  DramChannelConfig config;
  config.timing.faw = 57;
  std::vector<Request> requests;
  for (unsigned i = 0; i < 10; ++i) requests.push_back({100, i * kRow});
  const std::vector<Cycle> done = run(requests, config);
  for (unsigned i = 0; i < 10; ++i) {
    EXPECT_EQ(done[i], 100 + i / 4 * 57 + i % 4 * kTiming.rrd + kTiming.rcd + kTiming.cl + kTiming.ccd) << i;
  }
}

TEST(DramChannelTiming, ARefreshClosesAllRowsAndTakesRfc) {
  DramChannelConfig config;
  config.timing.refi = 2000;
  config.timing.rfc = 300;
  const Cycle idle = kTiming.rcd + kTiming.cl + kTiming.ccd;
  // Due in 2000: PRE, after RP the refresh, after RFC an activate.
  EXPECT_EQ(run({{1500, 0}, {1999, 32}}, config)[1], 1999 + kTiming.cl + kTiming.ccd) << "the last clock before";
  EXPECT_EQ(run({{1500, 0}, {2000, 32}}, config)[1], 2000 + kTiming.rp + 300 + idle);
  EXPECT_EQ(run({{1500, 0}, {2300, 32}}, config)[1], 2000 + kTiming.rp + 300 + idle) << "arrives meanwhile";
  EXPECT_EQ(run({{1500, 0}, {2400, 32}}, config)[1], 2400 + idle) << "the row is closed afterwards";
  // No row is open: no precharge.
  EXPECT_EQ(run({{2000, 0}}, config)[0], 2000 + 300 + idle);
  EXPECT_EQ(run({{6001, 0}}, config)[0], 6000 + 300 + idle) << "the third";
  // A row that was opened in 1999 is closed after RAS, and opened again.
  EXPECT_EQ(run({{1999, 0}}, config)[0], 1999 + kTiming.ras + kTiming.rp + 300 + idle);
}

TEST(DramChannelTiming, RefreshesAreCountedUntilTheLastColumnCommand) {
  DramChannelConfig config;
  config.timing.refi = 2000;
  config.timing.rfc = 300;
  DramChannel channel(config);
  for (const Cycle at : {Cycle{1999}, Cycle{9000}}) {
    channel.run_until(at - 1);
    channel.enqueue(at, 0, 0, 32, false);
  }
  channel.run_until(100'000);
  EXPECT_EQ(channel.counters().refreshes, 4U) << "in 2000, 4000, 6000 and 8000";
  EXPECT_EQ(channel.counters().activates, 3U) << "the first was closed before its read";
  EXPECT_EQ(channel.counters().precharges, 2U);
  EXPECT_EQ(channel.counters().row_misses, 2U);
}

TEST(DramChannelTiming, CountersTellHitsMissesAndConflicts) {
  DramChannel channel({});
  Cycle at = 100;
  for (const std::uint64_t address : {std::uint64_t{0}, std::uint64_t{32}, kSameBank, kSameBank + 64, kRow}) {
    channel.run_until(at - 1);
    channel.enqueue(at, 0, address, 32, address == kRow);
    at += 200;
  }
  channel.run_until(10000);
  const DramChannelCounters& c = channel.counters();
  EXPECT_EQ(c.row_hits, 2u);
  EXPECT_EQ(c.row_misses, 2u);
  EXPECT_EQ(c.row_conflicts, 1u);
  EXPECT_EQ(c.activates, 3u);
  EXPECT_EQ(c.precharges, 1u);
  EXPECT_EQ(c.reads, 4u);
  EXPECT_EQ(c.writes, 1u);
  EXPECT_EQ(c.bytes, 160u);
  // An entry leaves the queue with its column command: RCD clocks for misses, RP + RCD for conflicts, none for hits.
  EXPECT_EQ(c.queue_clocks, kTiming.rcd + 0 + (kTiming.rp + kTiming.rcd) + 0 + kTiming.rcd);
}

}  // namespace
}  // namespace grtx::modules
