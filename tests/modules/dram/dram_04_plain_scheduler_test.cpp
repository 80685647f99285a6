// SPDX-License-Identifier: Apache-2.0
// The channel keeps which banks are ready; the plain one of tests/rtl_tlm/plain, which looks at all requests in every
// clock, decides the same.
#include <gtest/gtest.h>

#include <vector>

#include "grtx/modules/dram/decide/dram_channel.h"
#include "modules/dram/dram_load.h"
#include "rtl_tlm/plain/dram_commands.h"

namespace grtx::modules {
namespace {

/// The plain commands with the time that run_load() brings.
class PlainChannel {
 public:
  explicit PlainChannel(const DramChannelConfig& config) : config_(config), commands_(config) {}

  bool can_accept(unsigned) const { return commands_.queued() < config_.queue; }
  void run_until(Cycle now) {
    for (; clock_ <= now; ++clock_) {
      const auto issued = commands_.step(clock_);
      if (issued.column) done_.push_back({issued.column->request, issued.done});
    }
  }
  void enqueue(Cycle now, std::uint64_t id, std::uint64_t address, unsigned, bool write) {
    commands_.enqueue(now, id, address, write);
  }
  std::size_t queued() const { return commands_.queued(); }
  const std::vector<DramDone>& done() const { return done_; }
  std::uint64_t refreshes() const { return commands_.refreshes(); }

 private:
  DramChannelConfig config_;
  sim::plain::DramCommands commands_;
  std::vector<DramDone> done_;
  Cycle clock_ = 0;
};

/// A part whose every key is another than the default's, with refreshes that are often late.
DramChannelConfig small_part() {
  DramChannelConfig config{.timing = {2, 5, 14, 30, 13, 47, 11, 5, 6, 15, 3, 1, 3, 9, 11, 9, 31, 400, 60},
                           .banks = 8,
                           .bank_groups = 4,
                           .group_bytes = 64,
                           .row_bytes = 1024,
                           .queue = 24,
                           .bank_xor = true};
  return config;
}

class DramPlainScheduler : public ::testing::TestWithParam<DramLoad> {
 protected:
  static void expect_same(DramChannelConfig config) {
    config.age_cap = GetParam().age_cap;
    DramChannel channel(config);
    PlainChannel plain(config);
    const std::vector<DramDone> done = run_load(channel, config, GetParam());
    EXPECT_EQ(done.size(), 3000U);
    EXPECT_EQ(done, run_load(plain, config, GetParam()));
    if (config.timing.refi != 0) {
      EXPECT_GT(channel.counters().refreshes, 20U);
    }
    EXPECT_EQ(channel.counters().refreshes, plain.refreshes());
  }
};

TEST_P(DramPlainScheduler, DecidesTheSame) { expect_same({}); }

TEST_P(DramPlainScheduler, DecidesTheSameWithBankGroupsAndRefresh) { expect_same(small_part()); }

TEST_P(DramPlainScheduler, DecidesTheSameWithEachAlone) {
  DramChannelConfig config;
  config.timing.refi = 700;
  config.timing.rfc = 100;
  expect_same(config);
  config = {};
  config.bank_groups = 2;
  config.timing.ccd_l = 7;
  expect_same(config);
  config = {};
  config.timing.rrd_l = 23;  // all banks are in one group
  config.timing.faw = 101;
  expect_same(config);
}

INSTANTIATE_TEST_SUITE_P(Loads, DramPlainScheduler, ::testing::ValuesIn(kDramLoads),
                         [](const auto& i) { return std::string(i.param.name); });

}  // namespace
}  // namespace grtx::modules
