// The channel keeps which banks are ready; a plain scheduler that looks at all requests in every clock decides the
// same.
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <vector>

#include "grtx/modules/dram/decide/dram_channel.h"
#include "modules/dram/dram_load.h"
#include "modules/dram/fr_fcfs_policy.h"

namespace grtx::modules {
namespace {

class PlainChannel {
 public:
  explicit PlainChannel(const DramChannelConfig& config)
      : config_(config), banks_(config.banks), groups_(config.bank_groups) {}

  bool can_accept(unsigned) const { return queue_.size() < config_.queue; }
  void run_until(Cycle now) {
    for (; clock_ <= now; ++clock_) step(clock_);
  }
  void enqueue(Cycle now, std::uint64_t id, std::uint64_t address, unsigned, bool write) {
    const std::uint64_t groups = config_.bank_groups;
    std::uint64_t group = 0;
    if (groups > 1) {
      const std::uint64_t block = address / config_.group_bytes;
      group = block % groups;
      address = block / groups * config_.group_bytes + address % config_.group_bytes;
    }
    const std::uint64_t number = address / config_.row_bytes;
    const std::uint64_t row = number / (config_.banks / groups);
    std::uint64_t bank = number % (config_.banks / groups) * groups + group;
    if (config_.bank_xor) bank ^= row % config_.banks;
    queue_.push_back({id, row, bank, now, write});
  }
  std::size_t queued() const { return queue_.size(); }
  const std::vector<DramDone>& done() const { return done_; }

 private:
  void step(Cycle now) {
    if (refreshes(now)) return;
    constexpr std::size_t kNone = ~std::size_t{0};
    std::size_t column = kNone, row = kNone, oldest_hit = kNone;  // places in the queue, in the order of arrival
    for (std::size_t b = 0; b < banks_.size(); ++b) {
      const Bank& bank = banks_[b];
      std::size_t oldest = kNone, hit = kNone;
      for (std::size_t i = 0; i < queue_.size(); ++i) {
        if (queue_[i].bank != b) continue;
        oldest = std::min(oldest, i);
        if (bank.open && queue_[i].row == bank.row) hit = std::min(hit, i);
      }
      if (oldest == kNone) continue;
      if (hit != kNone && (hit == oldest || !aged(oldest, now))) {
        oldest_hit = std::min(oldest_hit, hit);
        const Group& group = groups_[b % config_.bank_groups];
        const Cycle ready = queue_[hit].write ? std::max({bank.can_write, next_write_, group.write})
                                              : std::max({bank.can_read, next_read_, group.read});
        if (ready <= now) column = std::min(column, hit);
        continue;
      }
      const Cycle ready =
          bank.open ? bank.can_precharge
                    : std::max({bank.can_activate, next_activate_, groups_[b % config_.bank_groups].activate});
      if (ready <= now) row = std::min(row, oldest);
    }
    if (column != kNone && column != oldest_hit && aged(oldest_hit, now)) column = kNone;
    if (row != kNone) row_command(now, row);
    if (column != kNone) column_command(now, column);
  }

  struct Request {
    std::uint64_t id, row, bank;
    Cycle enqueued;
    bool write;
  };
  struct Bank {
    bool open = false;
    std::uint64_t row = 0;
    Cycle can_activate = 0, can_precharge = 0, can_read = 0, can_write = 0, last_activate = 0;
  };
  struct Group {
    Cycle read = 0, write = 0, activate = 0;
  };

  /// Whether this clock is a refresh's.
  bool refreshes(Cycle now) {
    const DramTiming& t = config_.timing;
    if (t.refi != 0 && now != 0 && now % t.refi == 0) due_ = true;
    if (!due_) return false;
    const auto open = [](const Bank& b) { return b.open; };
    if (std::any_of(banks_.begin(), banks_.end(), open)) {
      if (std::any_of(banks_.begin(), banks_.end(), [&](const Bank& b) { return b.open && b.can_precharge > now; })) {
        return true;
      }
      for (Bank& b : banks_) {
        if (b.open) b.can_activate = std::max(now + t.rp, b.last_activate + t.rc);
        b.open = false;
      }
    }
    if (std::any_of(banks_.begin(), banks_.end(), [&](const Bank& b) { return b.can_activate > now; })) return true;
    for (Bank& b : banks_) b.can_activate = now + t.rfc;
    due_ = false;
    return true;
  }

  bool aged(std::size_t i, Cycle now) const { return now - queue_[i].enqueued > config_.age_cap; }
  void row_command(Cycle now, std::size_t i) {
    const DramTiming& t = config_.timing;
    Bank& bank = banks_[queue_[i].bank];
    if (bank.open) {
      bank.open = false;
      bank.can_activate = std::max(now + t.rp, bank.last_activate + t.rc);
      return;
    }
    const Cycle can_write = now + (t.rcd_wr != 0 ? t.rcd_wr : t.rcd);
    bank = {true, queue_[i].row, bank.can_activate, now + t.ras, now + t.rcd, can_write, now};
    next_activate_ = now + t.rrd;
    groups_[queue_[i].bank % config_.bank_groups].activate = now + std::max(t.rrd, t.rrd_l);
    activates_.push_back(now);
    if (t.faw != 0 && activates_.size() >= 4) {
      next_activate_ = std::max(next_activate_, activates_[activates_.size() - 4] + t.faw);
    }
  }
  void column_command(Cycle now, std::size_t i) {
    const DramTiming& t = config_.timing;
    const Request request = queue_[i];
    next_read_ = std::max(next_read_, now + (request.write ? t.write_to_read() : t.ccd));
    next_write_ = std::max(next_write_, now + (request.write ? t.ccd : t.read_to_write()));
    Group& group = groups_[request.bank % config_.bank_groups];
    const Cycle ccd = std::max(t.ccd, t.ccd_l);
    group.read = std::max(group.read, now + (request.write ? t.wl + t.ccd + std::max(t.cdlr, t.cdlr_l) : ccd));
    group.write = std::max(group.write, now + ccd);
    Bank& bank = banks_[request.bank];
    bank.can_precharge = std::max(bank.can_precharge, now + (request.write ? t.write_to_precharge() : t.rtp));
    done_.push_back({request.id, now + (request.write ? t.wl : t.cl) + t.ccd});
    queue_.erase(queue_.begin() + static_cast<std::ptrdiff_t>(i));
  }

  DramChannelConfig config_;
  std::vector<Request> queue_;
  std::vector<Bank> banks_;
  std::vector<Group> groups_;
  std::vector<Cycle> activates_;
  bool due_ = false;  ///< a refresh
  std::vector<DramDone> done_;
  Cycle clock_ = 0;
  Cycle next_read_ = 0, next_write_ = 0, next_activate_ = 0;
};

/// A part whose every key is another than the default's, with refreshes that are often late.
DramChannelConfig small_part() {
  DramChannelConfig config;
  config.banks = 8;
  config.bank_groups = 4;
  config.group_bytes = 64;
  config.bank_xor = true;
  config.row_bytes = 1024;
  config.queue = 24;
  config.timing = {2, 5, 14, 30, 13, 47, 11, 5, 6, 15, 3, 1, 3, 9, 11, 9, 31, 400, 60};
  return config;
}

class DramPlainScheduler : public ::testing::TestWithParam<DramLoad> {
 protected:
  static void expect_same(DramChannelConfig config) {
    config.age_cap = GetParam().age_cap;
    DramChannel channel(config);
    DramChannel told(config, std::make_unique<FrFcfs>(config.age_cap));
    PlainChannel plain(config);
    const std::vector<DramDone> done = run_load(channel, config, GetParam());
    EXPECT_EQ(done.size(), 3000U);
    EXPECT_EQ(done, run_load(plain, config, GetParam()));
    EXPECT_EQ(done, run_load(told, config, GetParam())) << "the policy by its interface";
    if (config.timing.refi != 0) {
      EXPECT_GT(channel.counters().refreshes, 20U);
    }
    EXPECT_EQ(channel.counters().refreshes, told.counters().refreshes);
    EXPECT_EQ(channel.counters().activates, told.counters().activates);
    EXPECT_EQ(channel.counters().queue_clocks, told.counters().queue_clocks);
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
