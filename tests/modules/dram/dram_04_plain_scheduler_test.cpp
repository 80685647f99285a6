// The channel keeps which banks are ready; a plain scheduler that looks at all requests in every clock decides the
// same.
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "grtx/modules/dram/dram_channel.h"
#include "modules/dram/dram_load.h"

namespace grtx::modules {
namespace {

class PlainChannel {
 public:
  explicit PlainChannel(const DramChannelConfig& config) : config_(config), banks_(config.banks) {}

  bool can_accept(unsigned) const { return queue_.size() < config_.queue; }
  void run_until(Cycle now) {
    for (; clock_ <= now; ++clock_) step(clock_);
  }
  void enqueue(Cycle now, std::uint64_t id, std::uint64_t address, unsigned, bool write) {
    const std::uint64_t row = address / config_.row_bytes;
    queue_.push_back({id, row / config_.banks, row % config_.banks, now, write});
  }
  std::size_t queued() const { return queue_.size(); }
  const std::vector<DramDone>& done() const { return done_; }

 private:
  void step(Cycle now) {
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
        const Cycle ready = std::max(bank.can_column, queue_[hit].write ? next_write_ : next_read_);
        if (ready <= now) column = std::min(column, hit);
        continue;
      }
      const Cycle ready = bank.open ? bank.can_precharge : std::max(bank.can_activate, next_activate_);
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
    Cycle can_activate = 0, can_precharge = 0, can_column = 0, last_activate = 0;
  };

  bool aged(std::size_t i, Cycle now) const { return now - queue_[i].enqueued > config_.age_cap; }
  void row_command(Cycle now, std::size_t i) {
    const DramTiming& t = config_.timing;
    Bank& bank = banks_[queue_[i].bank];
    if (bank.open) {
      bank.open = false;
      bank.can_activate = std::max(now + t.rp, bank.last_activate + t.rc);
      return;
    }
    bank = {true, queue_[i].row, bank.can_activate, now + t.ras, now + t.rcd, now};
    next_activate_ = now + t.rrd;
  }
  void column_command(Cycle now, std::size_t i) {
    const DramTiming& t = config_.timing;
    const Request request = queue_[i];
    next_read_ = std::max(next_read_, now + (request.write ? t.write_to_read() : t.ccd));
    next_write_ = std::max(next_write_, now + (request.write ? t.ccd : t.read_to_write()));
    Bank& bank = banks_[request.bank];
    bank.can_precharge = std::max(bank.can_precharge, now + (request.write ? t.write_to_precharge() : t.rtp));
    done_.push_back({request.id, now + (request.write ? t.wl : t.cl) + t.ccd});
    queue_.erase(queue_.begin() + static_cast<std::ptrdiff_t>(i));
  }

  DramChannelConfig config_;
  std::vector<Request> queue_;
  std::vector<Bank> banks_;
  std::vector<DramDone> done_;
  Cycle clock_ = 0;
  Cycle next_read_ = 0, next_write_ = 0, next_activate_ = 0;
};

class DramPlainScheduler : public ::testing::TestWithParam<DramLoad> {};

TEST_P(DramPlainScheduler, DecidesTheSame) {
  DramChannelConfig config;
  config.age_cap = GetParam().age_cap;
  DramChannel channel(config);
  PlainChannel plain(config);
  const std::vector<DramDone> done = run_load(channel, config, GetParam());
  EXPECT_EQ(done.size(), 3000U);
  EXPECT_EQ(done, run_load(plain, config, GetParam()));
}

INSTANTIATE_TEST_SUITE_P(Loads, DramPlainScheduler, ::testing::ValuesIn(kDramLoads),
                         [](const auto& i) { return std::string(i.param.name); });

}  // namespace
}  // namespace grtx::modules
