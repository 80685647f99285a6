// DRAM channel: exact clocks of row hits, misses and conflicts, of turnarounds and of the four-bank pipeline.
#include <gtest/gtest.h>

#include "grtx/modules/dram/dram_channel.h"

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

constexpr DramTiming kT{};
constexpr std::uint64_t kRow = 2048;
constexpr std::uint64_t kSameBank = kRow * 16;  // the next row of the same bank

TEST(DramChannelTiming, ClosedRowHitAndConflict) {
  const Cycle idle = kT.rcd + kT.cl + kT.ccd;  // ACT, RD, data
  EXPECT_EQ(idle, 44u);
  EXPECT_EQ(run({{100, 0}})[0], 100 + idle);
  // The row stays open: a later request of the row needs the read only.
  EXPECT_EQ(run({{100, 0}, {1000, 64}})[1], 1000 + kT.cl + kT.ccd);
  // Another row of the bank: PRE, ACT, RD.
  EXPECT_EQ(run({{100, 0}, {1000, kSameBank}})[1], 1000 + kT.rp + idle);
  // Another bank is closed.
  EXPECT_EQ(run({{100, 0}, {1000, kRow}})[1], 1000 + idle);
}

TEST(DramChannelTiming, AnEarlyConflictWaitsForRas) {
  // ACT at 100; PRE not before 100 + RAS; ACT not before 100 + max(RAS + RP, RC).
  EXPECT_EQ(run({{100, 0}, {101, kSameBank}})[1], 100 + kT.ras + kT.rp + kT.rcd + kT.cl + kT.ccd);
  DramChannelConfig slow_rc;
  slow_rc.timing.rc = 90;
  EXPECT_EQ(run({{100, 0}, {101, kSameBank}}, slow_rc)[1], 100 + 90 + kT.rcd + kT.cl + kT.ccd);
}

TEST(DramChannelTiming, Writes) {
  EXPECT_EQ(run({{100, 0, true}})[0], 100 + kT.rcd + kT.wl + kT.ccd);
  // Write to read of the same row: WL + burst + CDLR between the commands.
  EXPECT_EQ(run({{100, 0, true}, {101, 32}})[1], 100 + kT.rcd + (kT.wl + kT.ccd + kT.cdlr) + kT.cl + kT.ccd);
  // Read to write: CL + burst + 2 - WL between the commands.
  EXPECT_EQ(run({{100, 0}, {101, 32, true}})[1], 100 + kT.rcd + (kT.cl + kT.ccd + 2 - kT.wl) + kT.wl + kT.ccd);
  // A conflict after a write: precharge not before WR = 20 clocks after the last data, here later than RAS.
  EXPECT_EQ(run({{100, 0, true}, {101, kSameBank}})[1],
            100 + kT.rcd + (kT.wl + kT.ccd + kT.wr) + kT.rp + kT.rcd + kT.cl + kT.ccd);
}

TEST(DramChannelTiming, RowHitsStreamOneBurstEveryCcd) {
  std::vector<Request> requests;
  for (unsigned i = 0; i < 32; ++i) requests.push_back({100, i * 32});
  const std::vector<Cycle> done = run(requests);
  for (unsigned i = 0; i < 32; ++i) EXPECT_EQ(done[i], 100 + kT.rcd + i * kT.ccd + kT.cl + kT.ccd);
}

TEST(DramChannelTiming, BanksActivateRrdApart) {
  std::vector<Request> requests;
  for (unsigned i = 0; i < 16; ++i) requests.push_back({100, i * kRow});
  const std::vector<Cycle> done = run(requests);
  for (unsigned i = 0; i < 16; ++i) EXPECT_EQ(done[i], 100 + i * kT.rrd + kT.rcd + kT.cl + kT.ccd);
}

TEST(DramChannelTiming, ALineIsFourBursts) {
  EXPECT_EQ(run({{100, 0, false, 128}})[0], 100 + kT.rcd + 3 * kT.ccd + kT.cl + kT.ccd);
  EXPECT_EQ(run({{100, 0, false, 8}})[0], 100 + kT.rcd + kT.cl + kT.ccd) << "less than a burst takes a burst";
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
  EXPECT_EQ(c.queue_clocks, kT.rcd + 0 + (kT.rp + kT.rcd) + 0 + kT.rcd);
}

}  // namespace
}  // namespace grtx::modules
