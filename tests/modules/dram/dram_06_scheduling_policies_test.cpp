// SPDX-License-Identifier: Apache-2.0
// DRAM scheduling policies: what each chooses, alone and in a channel; one of the user's own.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <memory>
#include <stdexcept>
#include <string>

#include "grtx/base/error.h"
#include "grtx/modules/dram/decide/dram_channel.h"
#include "grtx/modules/kernel/wrong_answer.h"
#include "modules/dram/dram_load.h"

namespace grtx::modules {
namespace {

constexpr unsigned kNone = DramQueues::kNone;

DramChannelConfig with_scheduling(const char* name) {
  DramChannelConfig config{.scheduling = name};
  return config;
}

// --- Alone.

struct BankQueue {
  unsigned bank;
  std::uint64_t oldest;  ///< request, since clock 0
  bool row_ready;
  std::uint64_t hit;  ///< request; 0: there is none
  bool column_ready;
};
/// A bank whose oldest request wants another row than its hit, if it has one.
BankQueue conflict(unsigned bank, std::uint64_t oldest, bool ready, std::uint64_t hit = 0, bool hit_ready = false) {
  return {bank, oldest, ready, hit, hit_ready};
}
/// A bank whose oldest request is a row hit.
BankQueue hit(unsigned bank, std::uint64_t oldest, bool ready) { return {bank, oldest, false, oldest, ready}; }

DramQueues shown(const std::vector<BankQueue>& banks) {
  DramQueues queues;
  queues.oldest.resize(16);
  queues.hit.resize(16);
  for (const BankQueue& b : banks) {
    const std::uint64_t bit = std::uint64_t{1} << b.bank;
    queues.busy |= bit;
    queues.oldest[b.bank].order = b.oldest;
    queues.hit[b.bank].order = b.hit;
    if (b.hit != 0) queues.hits |= bit;
    if (b.hit != 0 && b.hit != b.oldest) queues.overtaking |= bit;
    if (b.column_ready) queues.columns |= bit;
    if (b.row_ready) queues.rows |= bit;
  }
  return queues;
}

struct Choice {
  const char* policy;
  Cycle now;
  std::vector<BankQueue> banks;
  unsigned column;  ///< bank
  unsigned row;
};

TEST(DramScheduling, WhatEachChooses) {
  const std::vector<BankQueue> mixed = {conflict(0, 3, true, 9, true), hit(1, 5, true), conflict(2, 4, true),
                                        hit(3, 7, true)};
  const Choice cases[] = {{"fr_fcfs", 0, mixed, 1, 2},  // bank 0 serves its hit first, which is younger than bank 1's
                          {"fr_fcfs", 1025, mixed, 1, 0},  // all are aged: bank 0 makes way; 5 is the oldest hit
                          {"fr_fcfs_cap", 0, mixed, 1, 2},
                          {"fcfs", 0, mixed, kNone, 0},  // 3 is the oldest, and its row is not open
                          {"fcfs", 0, {hit(1, 5, true), conflict(2, 6, true)}, 1, 2},
                          {"fcfs", 0, {hit(1, 5, false), hit(2, 6, true)}, kNone, kNone},  // 6 does not overtake 5
                          {"fr_fcfs", 0, {hit(1, 5, false), hit(2, 6, true)}, 2, kNone},   // but here it does
                          {"fr_fcfs", 1025, {hit(1, 5, false), hit(2, 6, true)}, kNone, kNone}};  // until 5 has aged
  for (const Choice& c : cases) {
    const DramChoice choice = make_dram_scheduling(with_scheduling(c.policy))->choose(c.now, shown(c.banks));
    EXPECT_EQ(choice.column, c.column) << c.policy << " at " << c.now;
    EXPECT_EQ(choice.row, c.row) << c.policy << " at " << c.now;
  }
}

TEST(DramScheduling, TheCapIsForEachBankAndForgottenWithTheRow) {
  DramChannelConfig config = with_scheduling("fr_fcfs_cap");
  config.hit_cap = 2;
  const auto policy = make_dram_scheduling(config);
  const DramQueues one = shown({conflict(0, 1, true, 8, true)});
  EXPECT_EQ(policy->choose(0, one).column, 0U);
  EXPECT_EQ(policy->choose(1, one).column, 0U);
  DramChoice third = policy->choose(2, one);
  EXPECT_EQ(third.column, kNone);
  EXPECT_EQ(third.row, 0U) << "two have overtaken";
  EXPECT_EQ(policy->choose(3, one).column, 0U) << "another request, since the oldest got its row command";
  EXPECT_EQ(policy->choose(4, shown({conflict(1, 2, true, 9, true)})).column, 1U) << "another bank";
  EXPECT_EQ(DramChannel(config).scheduling_bits_per_bank(), 2U);
}

// --- In a channel.

class DramScheduled : public ::testing::TestWithParam<DramLoad> {};

/// Asks in every clock in which something is ready, and so also where the policy would not have been asked.
class NeverDeclines final : public DramScheduling {
 public:
  explicit NeverDeclines(const DramChannelConfig& config) : policy_(make_dram_scheduling(config)) {}
  DramChoice choose(Cycle now, const DramQueues& queues) override {
    const DramChoice choice = policy_->choose(now, queues);
    return {choice.column, choice.row};
  }

 private:
  std::unique_ptr<DramScheduling> policy_;
};

TEST_P(DramScheduled, WhatAPolicyDeclinesChangesNothing) {
  for (const char* scheduling : {"fr_fcfs", "fr_fcfs_cap"}) {
    for (const unsigned cap : {1U, 4U}) {
      DramChannelConfig config = with_scheduling(scheduling);
      config.age_cap = GetParam().age_cap;
      config.hit_cap = cap;
      DramChannel own(config), asked(config, std::make_unique<NeverDeclines>(config));
      EXPECT_EQ(run_load(own, config, GetParam()), run_load(asked, config, GetParam())) << scheduling << " " << cap;
      EXPECT_EQ(own.counters().activates, asked.counters().activates) << scheduling << " " << cap;
      EXPECT_EQ(own.counters().queue_clocks, asked.counters().queue_clocks) << scheduling << " " << cap;
      EXPECT_EQ(own.counters().aged, asked.counters().aged) << scheduling << " " << cap;
    }
  }
}

TEST_P(DramScheduled, ACapThatIsNeverReachedIsNone) {
  DramChannelConfig config{.age_cap = GetParam().age_cap};
  DramChannel free(config);
  config.scheduling = "fr_fcfs_cap";
  config.hit_cap = 1'000'000;
  DramChannel capped(config);
  EXPECT_EQ(run_load(free, config, GetParam()), run_load(capped, config, GetParam()));
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
  constexpr Cycle kData = kTiming.cl + kTiming.ccd;
  const Cycle first = 100 + kTiming.rcd;
  const Cycle second = 100 + kTiming.ras + kTiming.rp + kTiming.rcd;  // the conflict
  EXPECT_EQ(run(with_scheduling("fcfs"), {0, kSameBank, 32, kRow}),
            (std::vector<DramDone>{
                {0, first + kData},
                {1, second + kData},
                // row 0 again, not before RC and RAS + RP after the conflict's activate
                {2, second - kTiming.rcd + kTiming.ras + kTiming.rp + kTiming.rcd + kData},
                // opened long before, in turn on the bus
                {3, second - kTiming.rcd + kTiming.ras + kTiming.rp + kTiming.rcd + kTiming.ccd + kData}}));
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
  DramChoice choose(Cycle, const DramQueues& queues) override {
    DramChoice choice;
    if (queues.columns != 0) choice.column = 63U - static_cast<unsigned>(std::countl_zero(queues.columns));
    const std::uint64_t rows =
        choice.column == kNone ? queues.rows : queues.rows & ~(std::uint64_t{1} << choice.column);
    if (rows != 0) choice.row = 63U - static_cast<unsigned>(std::countl_zero(rows));
    return choice;
  }
};

TEST(DramScheduling, OneOfTheUsersIsRegisteredByName) {
  register_dram_scheduling("highest_bank", [](const DramChannelConfig&) { return std::make_unique<HighestBank>(); });
  EXPECT_EQ(dram_scheduling_names().back(), "highest_bank");
  EXPECT_THROW(register_dram_scheduling("fr_fcfs", {}), std::logic_error);
  // Two rows are opened a clock apart by RRD, the higher bank's first.
  const std::vector<DramDone> done = run(with_scheduling("highest_bank"), {0, 3 * kRow});
  EXPECT_EQ(done, (std::vector<DramDone>{{1, 100 + kTiming.rcd + kTiming.cl + kTiming.ccd},
                                         {0, 100 + kTiming.rrd + kTiming.rcd + kTiming.cl + kTiming.ccd}}));
}

/// Names what it should not.
class Wrong final : public DramScheduling {
 public:
  explicit Wrong(DramChoice choice) : choice_(choice) {}
  DramChoice choose(Cycle, const DramQueues&) override { return choice_; }

 private:
  DramChoice choice_;
};

TEST(DramScheduling, ACommandThatIsNotReadyIsAnError) {
  // No row is open; the bank is not ready; no such bank.
  for (const DramChoice choice : {DramChoice{0, kNone}, DramChoice{kNone, 7}, DramChoice{4711, kNone}}) {
    DramChannel channel({}, std::make_unique<Wrong>(choice));
    channel.enqueue(100, 0, 0, 32, false);
    EXPECT_THAT([&] { channel.run_until(200); },
                ::testing::ThrowsMessage<WrongAnswer>(::testing::HasSubstr(
                    "the DRAM scheduling fr_fcfs chose a command that is not ready: row of bank ")));
  }
  DramChannel waits({}, std::make_unique<Wrong>(DramChoice{}));
  waits.enqueue(100, 0, 0, 32, false);
  waits.run_until(200);
  EXPECT_EQ(waits.next_command(), 201U) << "asked again in every clock";
}

/// Never chooses, and says that it never will.
class Refuses final : public DramScheduling {
 public:
  DramChoice choose(Cycle, const DramQueues& queues) override {
    return {.declined_columns = queues.columns, .declined_rows = queues.rows};
  }
};

TEST(DramScheduling, APolicyThatNeverChoosesHangsNoFullQueue) {
  DramChannelConfig config;
  config.queue = 4;
  config.timing.refi = 0;  // no refresh asks again
  DramChannel channel(config, std::make_unique<Refuses>());
  for (unsigned i = 0; i < config.queue; ++i) channel.enqueue(100, i, 0, 32, false);
  EXPECT_THAT([&] { channel.run_until_room(32); },
              ::testing::ThrowsMessage<WrongAnswer>(::testing::HasSubstr("declines every command of a full queue")));
}

// Unlike the one above it declines nothing: it was asked again in every clock, for ever.
TEST(DramScheduling, APolicyThatNeverAnswersHangsNoFullQueue) {
  DramChannelConfig config;
  config.queue = 4;
  DramChannel channel(config, std::make_unique<Wrong>(DramChoice{}));
  for (unsigned i = 0; i < config.queue; ++i) channel.enqueue(100, i, 0, 32, false);
  EXPECT_THAT([&] { channel.run_until_room(32); },
              ::testing::ThrowsMessage<WrongAnswer>(::testing::HasSubstr("declines every command of a full queue")));
}

TEST(DramScheduling, AFactoryThatMakesNothingIsNamed) {
  register_dram_scheduling("nothing", [](const DramChannelConfig&) { return nullptr; });
  EXPECT_THAT([] { DramChannel{with_scheduling("nothing")}; },
              ::testing::ThrowsMessage<Error>(
                  ::testing::HasSubstr("dram.scheduling: the factory of the DRAM scheduling nothing made nothing")));
}

/// Nodes of SM 1 before all else.
class NodesOfSmOneFirst final : public DramScheduling {
 public:
  DramChoice choose(Cycle, const DramQueues& queues) override {
    std::uint64_t nodes = 0;
    for (unsigned bank = 0; bank < queues.oldest.size(); ++bank) {
      const RequestOrigin& origin = queues.oldest[bank].origin;
      if (is_node(origin.region) && origin.sm == 1) nodes |= std::uint64_t{1} << bank;
    }
    DramChoice choice;
    choice.column = DramQueues::oldest_of(queues.columns, queues.hit);
    choice.row = DramQueues::oldest_of(queues.rows & nodes, queues.oldest);
    if (choice.row == kNone) choice.row = DramQueues::oldest_of(queues.rows & queues.busy, queues.oldest);
    return choice;
  }
};

TEST(DramScheduling, APolicyKnowsWhoAsksAndForWhat) {
  DramChannel channel({}, std::make_unique<NodesOfSmOneFirst>());
  channel.enqueue(100, 0, 0, 32, false, {1, Region::gaussian});
  channel.enqueue(100, 1, kRow, 32, false, {2, Region::blas});
  channel.enqueue(100, 2, 2 * kRow, 32, false, {1, Region::blas});
  channel.run_until(100'000);
  const Cycle first = 100 + kTiming.rcd + kTiming.cl + kTiming.ccd;
  EXPECT_EQ(done_by(channel),
            (std::vector<DramDone>{{2, first}, {0, first + kTiming.rrd}, {1, first + 2 * kTiming.rrd}}));
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
