// The channel keeps which banks are ready; a plain scheduler that looks at all requests in every clock decides the
// same.
#include <gtest/gtest.h>

#include <algorithm>
#include <ostream>
#include <random>
#include <vector>

#include "grtx/modules/dram/dram_channel.h"

namespace grtx::modules {
namespace {

struct Done {
  std::uint64_t id;
  Cycle done;
  bool operator==(const Done&) const = default;
  friend void PrintTo(const Done& d, std::ostream* out) { *out << d.id << " at " << d.done; }
};

class PlainChannel {
 public:
  explicit PlainChannel(const DramChannelConfig& config) : config_(config), banks_(config.banks) {}

  bool can_accept() const { return queue_.size() < config_.queue; }
  void enqueue(Cycle now, std::uint64_t id, std::uint64_t address, bool write) {
    const std::uint64_t row = address / config_.row_bytes;
    queue_.push_back({id, row / config_.banks, row % config_.banks, now, write});
  }
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
  bool empty() const { return queue_.empty(); }
  const std::vector<Done>& done() const { return done_; }

 private:
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
  std::vector<Done> done_;
  Cycle next_read_ = 0, next_write_ = 0, next_activate_ = 0;
};

struct Load {
  const char* name;
  Cycle age_cap;
  unsigned rows;    ///< of a bank that requests go to
  unsigned writes;  ///< of ten requests
  unsigned pause;   ///< clocks between requests, 0 to this
  friend void PrintTo(const Load& load, std::ostream* out) { *out << load.name; }
};

class DramPlainScheduler : public ::testing::TestWithParam<Load> {};

TEST_P(DramPlainScheduler, DecidesTheSame) {
  const Load load = GetParam();
  DramChannelConfig config;
  config.age_cap = load.age_cap;
  DramChannel channel(config);
  PlainChannel plain(config);
  std::vector<Done> done;
  std::mt19937_64 random(11);
  std::uint64_t id = 0;
  Cycle next = 1;
  for (Cycle clock = 1; id < 3000 || !plain.empty(); ++clock) {
    channel.run_until(clock - 1);
    ASSERT_EQ(channel.can_accept(config.burst_bytes), plain.can_accept()) << "clock " << clock;
    if (id < 3000 && clock >= next && plain.can_accept()) {
      const std::uint64_t row = random() % load.rows * config.banks + random() % config.banks;
      const std::uint64_t address = row * config.row_bytes + random() % 64 * config.burst_bytes;
      const bool write = random() % 10 < load.writes;
      channel.enqueue(clock, id, address, config.burst_bytes, write);
      plain.enqueue(clock, id++, address, write);
      next = clock + random() % (load.pause + 1);
    }
    plain.step(clock);
  }
  channel.run_until(kNever - 1);
  for (auto& all = channel.completions(); !all.empty(); all.pop()) done.push_back({all.front().id, all.front().done});
  EXPECT_EQ(done.size(), 3000U);
  EXPECT_EQ(done, plain.done());
}

INSTANTIATE_TEST_SUITE_P(Loads, DramPlainScheduler,
                         ::testing::Values(Load{"idle", 1024, 8, 2, 200}, Load{"reads", 1024, 4, 0, 6},
                                           Load{"mixed", 1024, 8, 3, 8}, Load{"saturated", 1024, 16, 2, 0},
                                           Load{"ages_early", 40, 4, 3, 4}, Load{"ages_and_full", 200, 3, 5, 0}),
                         [](const auto& i) { return std::string(i.param.name); });

}  // namespace
}  // namespace grtx::modules
