// DRAM scheduling policies: what each chooses, alone and in a channel; one of the user's own.
#include <gtest/gtest.h>

#include <limits>
#include <memory>
#include <stdexcept>
#include <string>

#include "grtx/base/error.h"
#include "grtx/modules/dram/decide/dram_channel.h"
#include "modules/dram/dram_load.h"
#include "modules/dram/fr_fcfs_policy.h"

namespace grtx::modules {
namespace {

constexpr DramTiming kT{};
constexpr std::uint64_t kRow = 2048;
constexpr std::uint64_t kSameBank = kRow * 16;
constexpr std::size_t kNone = DramChoice::kNone;

DramChannelConfig with_scheduling(const char* name) {
  DramChannelConfig config{.scheduling = name};
  return config;
}

/// That of the configuration, where it is built into the channel said as a policy.
std::unique_ptr<DramScheduling> policy_of(const DramChannelConfig& config) {
  if (config.scheduling == kFrFcfs) return std::make_unique<FrFcfs>(config.age_cap);
  if (config.scheduling == kFrFcfsCap) return std::make_unique<FrFcfsCap>(config);
  return make_dram_scheduling(config);
}

// --- Alone.

/// A bank whose oldest request, since clock 0, wants another row than its hit, if it has one.
DramBankQueue conflict(unsigned bank, std::uint64_t oldest, bool ready, std::uint64_t hit = 0, bool hit_ready = false) {
  DramBankQueue queue{
      .bank = bank, .oldest = oldest, .has_hit = hit != 0, .hit = hit, .column_ready = hit_ready, .row_ready = ready};
  return queue;
}
/// A bank whose oldest request is a row hit.
DramBankQueue hit(unsigned bank, std::uint64_t oldest, bool ready) {
  DramBankQueue queue = conflict(bank, oldest, false, oldest, ready);
  return queue;
}

struct Choice {
  const char* policy;
  Cycle now;
  std::vector<DramBankQueue> queues;
  std::size_t column;
  std::size_t row;
};

TEST(DramScheduling, WhatEachChooses) {
  const std::vector<DramBankQueue> mixed = {conflict(0, 3, true, 9, true), hit(1, 5, true), conflict(2, 4, true),
                                            hit(3, 7, true)};
  const Choice cases[] = {{"fr_fcfs", 0, mixed, 1, 2},  // bank 0 serves its hit first, which is younger than bank 1's
                          {"fr_fcfs", 1025, mixed, 1, 0},  // all are aged: bank 0 makes way; 5 is the oldest hit
                          {"fr_fcfs_cap", 0, mixed, 1, 2},
                          {"fcfs", 0, mixed, kNone, 0},  // 3 is the oldest, and its row is not open
                          {"fcfs", 0, {hit(1, 5, true), conflict(2, 6, true)}, 0, 1},
                          {"fcfs", 0, {hit(1, 5, false), hit(2, 6, true)}, kNone, kNone},  // 6 does not overtake 5
                          {"fr_fcfs", 0, {hit(1, 5, false), hit(2, 6, true)}, 1, kNone},   // but here it does
                          {"fr_fcfs", 1025, {hit(1, 5, false), hit(2, 6, true)}, kNone, kNone}};  // until 5 has aged
  for (const Choice& c : cases) {
    const DramChoice choice = policy_of(with_scheduling(c.policy))->choose(c.now, c.queues);
    EXPECT_EQ(choice.column, c.column) << c.policy << " at " << c.now;
    EXPECT_EQ(choice.row, c.row) << c.policy << " at " << c.now;
  }
}

TEST(DramScheduling, TheCapIsForEachBankAndForgottenWithTheRow) {
  DramChannelConfig config = with_scheduling("fr_fcfs_cap");
  config.hit_cap = 2;
  const auto policy = policy_of(config);
  const std::vector<DramBankQueue> one = {conflict(0, 1, true, 8, true)};
  EXPECT_EQ(policy->choose(0, one).column, 0U);
  EXPECT_EQ(policy->choose(1, one).column, 0U);
  DramChoice third = policy->choose(2, one);
  EXPECT_EQ(third.column, kNone);
  EXPECT_EQ(third.row, 0U) << "two have overtaken";
  EXPECT_EQ(policy->choose(3, one).column, 0U) << "another request, since the oldest got its row command";
  EXPECT_EQ(policy->choose(4, {conflict(1, 2, true, 9, true)}).column, 0U) << "another bank";
  EXPECT_EQ(DramChannel(config).scheduling_bits_per_bank(), 2U);
}

// --- In a channel.

class DramScheduled : public ::testing::TestWithParam<DramLoad> {};

TEST_P(DramScheduled, TheChannelsOwnDecisionsAreThoseOfFrFcfs) {
  DramChannelConfig config{.age_cap = GetParam().age_cap};
  DramChannel own(config);
  DramChannel told(config, std::make_unique<FrFcfs>(config.age_cap));
  config.scheduling = "fr_fcfs_cap";
  config.hit_cap = 1'000'000;
  DramChannel capped(config);
  const std::vector<DramDone> done = run_load(own, config, GetParam());
  EXPECT_EQ(done, run_load(told, config, GetParam()));
  EXPECT_EQ(done, run_load(capped, config, GetParam())) << "a cap that is never reached";
  EXPECT_EQ(own.counters().aged, told.counters().aged);
  EXPECT_EQ(own.counters().activates, told.counters().activates);
  EXPECT_EQ(own.counters().queue_clocks, told.counters().queue_clocks);
}

TEST_P(DramScheduled, TheChannelsOwnDecisionsAreThoseOfFrFcfsCap) {
  for (const unsigned cap : {1U, 2U, 4U, 9U}) {
    DramChannelConfig config = with_scheduling("fr_fcfs_cap");
    config.age_cap = GetParam().age_cap;
    config.hit_cap = cap;
    DramChannel own(config), told(config, std::make_unique<FrFcfsCap>(config));
    EXPECT_EQ(run_load(own, config, GetParam()), run_load(told, config, GetParam())) << cap;
    EXPECT_EQ(own.counters().activates, told.counters().activates) << cap;
    EXPECT_EQ(own.counters().queue_clocks, told.counters().queue_clocks) << cap;
    EXPECT_EQ(own.counters().aged, told.counters().aged) << cap;
  }
}

TEST_P(DramScheduled, FcfsGivesDataInOrderOfArrival) {
  const DramChannelConfig config = with_scheduling("fcfs");
  DramChannel channel(config);
  const std::vector<DramDone> done = run_load(channel, config, GetParam());
  ASSERT_EQ(done.size(), 3000U);
  for (std::size_t i = 0; i < done.size(); ++i) EXPECT_EQ(done[i].id, i);
}

INSTANTIATE_TEST_SUITE_P(Loads, DramScheduled, ::testing::ValuesIn(kDramLoads),
                         [](const auto& i) { return std::string(i.param.name); });

/// Requests that all arrive in clock 100, and when their data is there.
std::vector<DramDone> run(const DramChannelConfig& config, const std::vector<std::uint64_t>& addresses) {
  DramChannel channel(config);
  for (std::size_t i = 0; i < addresses.size(); ++i) channel.enqueue(100, i, addresses[i], 32, false);
  channel.run_until(100'000);
  return done_by(channel);
}

TEST(DramScheduling, FcfsServesAConflictBeforeYoungerHitsWhileOtherBanksPrepare) {
  constexpr Cycle kData = kT.cl + kT.ccd;
  const Cycle first = 100 + kT.rcd;
  const Cycle second = 100 + kT.ras + kT.rp + kT.rcd;  // the conflict
  EXPECT_EQ(run(with_scheduling("fcfs"), {0, kSameBank, 32, kRow}),
            (std::vector<DramDone>{{0, first + kData},
                                   {1, second + kData},
                                   // row 0 again, not before RC and RAS + RP after the conflict's activate
                                   {2, second - kT.rcd + kT.ras + kT.rp + kT.rcd + kData},
                                   // opened long before, in turn on the bus
                                   {3, second - kT.rcd + kT.ras + kT.rp + kT.rcd + kT.ccd + kData}}));
}

TEST(DramScheduling, TheCapLetsSoManyHitsOvertake) {
  DramChannelConfig config = with_scheduling("fr_fcfs_cap");
  config.timing.ras = 22;  // so that the row could be closed after the first hit
  config.hit_cap = 3;
  std::vector<std::uint64_t> addresses = {0, kSameBank};
  for (std::uint64_t i = 1; i < 10; ++i) addresses.push_back(i * 32);
  std::vector<std::uint64_t> order;
  for (const DramDone& done : run(config, addresses)) order.push_back(done.id);
  EXPECT_EQ(order, (std::vector<std::uint64_t>{0, 2, 3, 4, 1, 5, 6, 7, 8, 9, 10}));
}

// --- One of the user's own.

/// The highest bank that is ready.
class HighestBank final : public DramScheduling {
 public:
  DramChoice choose(Cycle, const std::vector<DramBankQueue>& queues) override {
    DramChoice choice;
    for (std::size_t i = 0; i < queues.size(); ++i) {
      if (queues[i].column_ready)
        choice.column = i;
      else if (queues[i].row_ready)
        choice.row = i;
    }
    return choice;
  }
};

TEST(DramScheduling, OneOfTheUsersIsRegisteredByName) {
  register_dram_scheduling("highest_bank", [](const DramChannelConfig&) { return std::make_unique<HighestBank>(); });
  EXPECT_EQ(dram_scheduling_names().back(), "highest_bank");
  EXPECT_THROW(register_dram_scheduling("fr_fcfs", {}), std::logic_error);
  // Two rows are opened a clock apart by RRD, the higher bank's first.
  const std::vector<DramDone> done = run(with_scheduling("highest_bank"), {0, 3 * kRow});
  EXPECT_EQ(done,
            (std::vector<DramDone>{{1, 100 + kT.rcd + kT.cl + kT.ccd}, {0, 100 + kT.rrd + kT.rcd + kT.cl + kT.ccd}}));
}

/// Names what it should not.
class Wrong final : public DramScheduling {
 public:
  explicit Wrong(DramChoice choice) : choice_(choice) {}
  DramChoice choose(Cycle, const std::vector<DramBankQueue>&) override { return choice_; }

 private:
  DramChoice choice_;
};

TEST(DramScheduling, ACommandThatIsNotReadyIsAnError) {
  for (const DramChoice choice : {DramChoice{0, kNone}, DramChoice{kNone, 7}}) {  // no row is open; no such bank
    DramChannel channel({}, std::make_unique<Wrong>(choice));
    channel.enqueue(100, 0, 0, 32, false);
    EXPECT_ANY_THROW(channel.run_until(200));
  }
  DramChannel waits({}, std::make_unique<Wrong>(DramChoice{}));
  waits.enqueue(100, 0, 0, 32, false);
  waits.run_until(200);
  EXPECT_EQ(waits.next_command(), 201U) << "asked again in every clock";
}

TEST(DramScheduling, AnUnknownNameIsAnErrorThatListsTheKnownOnes) {
  for (const auto& make : {+[](const DramChannelConfig& c) { DramChannel{c}; },
                           +[](const DramChannelConfig& c) { make_dram_scheduling(c); }}) {
    EXPECT_THAT([&] { make(with_scheduling("lcfs")); },
                ::testing::ThrowsMessage<Error>(::testing::HasSubstr("fr_fcfs, fcfs, fr_fcfs_cap")));
  }
}

}  // namespace
}  // namespace grtx::modules
