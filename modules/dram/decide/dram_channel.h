// SPDX-License-Identifier: Apache-2.0
// One DRAM channel: banks with open rows and command timing, scheduled by a policy. Plain C++, no SystemC.
// GPGPU-Sim's GDDR model as configured by Vulkan-Sim; optional bank groups and refresh (docs/model/dram.md).
#pragma once

#include <array>
#include <cstdint>
#include <iosfwd>
#include <memory>
#include <vector>

#include "grtx/base/state_bytes.h"
#include "grtx/base/strong.h"
#include "grtx/modules/dram/decide/dram_config.h"
#include "grtx/modules/dram/decide/dram_mapping.h"
#include "grtx/modules/kernel/ring_queue.h"

namespace grtx::modules {

/// Commands depend only on the requests, so the channel is simulated lazily: run_until() executes everything up to a
/// clock and skips clocks in which nothing can issue. At most one row and one column command per clock.
class DramChannel {
 public:
  struct Completion {
    std::uint64_t id = 0;
    Cycle done = 0;  ///< clock after the last data clock
  };

  /// Throws Error for an impossible configuration.
  explicit DramChannel(const DramChannelConfig& config);
  /// scheduling: replaces the policy that config names, unless nullptr.
  DramChannel(const DramChannelConfig& config, std::unique_ptr<DramScheduling> scheduling);

  unsigned bursts(unsigned bytes) const { return (bytes + config_.burst_bytes - 1) / config_.burst_bytes; }
  bool can_accept(unsigned bytes) const { return queued_bursts_ + bursts(bytes) <= config_.queue; }
  /// Adds a request that may issue from clock `now` on. Requires run_until(now - 1) and can_accept(). address:
  /// channel-local byte address; the request lies within one row. id: returned with the completion. origin: for the
  /// policy.
  void enqueue(Cycle now, std::uint64_t id, std::uint64_t address, unsigned bytes, bool write,
               RequestOrigin origin = {});
  /// Counts a request that a perfect memory answers without the channel.
  void count_unqueued(unsigned bytes, bool write) {
    ++(write ? counters_.writes : counters_.reads);
    counters_.bytes += bytes;
  }
  /// Executes all commands of clocks <= now.
  void run_until(Cycle now) {
    while (next_ <= now) step(next_);
  }
  /// Executes one clock. Called by run_until() for clocks in which a command can issue; has no effect in others.
  void step(Cycle now);
  /// Runs ahead until the queue has room for `bytes`. Returns the clock of the command that made room; nothing may be
  /// enqueued for an earlier clock afterwards.
  Cycle run_until_room(unsigned bytes);

  /// Completions in order of `done`, that is, of the data bus.
  RingQueue<Completion>& completions() { return completions_; }
  /// Lower bound of `done` for all completions not yet in completions(); kNever if nothing is queued.
  Cycle completion_bound() const;
  Cycle next_command() const { return next_; }
  /// For another launch, with clocks from 0: back to the constructed state, with open rows kept or all rows closed.
  void restart(bool keep_rows);
  /// Save and restore what restart(true) keeps: the open rows. load() needs a newly constructed channel.
  void save(StateWriter& state) const {
    for (const Bank& bank : banks_) {
      state.put(static_cast<std::uint8_t>(bank.open));
      state.put(bank.row);
    }
  }
  void load(StateReader& state) {
    for (Bank& bank : banks_) {
      bank.open = state.get(std::uint8_t{1}) != 0;
      bank.row = state.get<std::uint64_t>();
    }
  }
  bool idle() const { return queued_ == 0 && completions_.empty(); }
  std::size_t queued() const { return queued_; }
  const DramChannelCounters& counters() const { return counters_; }
  const DramChannelConfig& config() const { return config_; }
  /// Hardware state of the scheduling policy, in bits per bank.
  unsigned scheduling_bits_per_bank() const { return scheduling_->bits_per_bank(); }
  void dump_state(std::ostream& out) const;

 private:
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};

  struct Entry {
    std::uint64_t id = 0;
    std::uint64_t row = 0;
    std::uint64_t order = 0;  ///< arrival number in the channel
    Cycle enqueued = 0;
    std::uint32_t newer = kNone;  ///< neighbours in the bank's list
    std::uint32_t older = kNone;
    std::uint32_t bank = 0;
    unsigned remaining = 0;  ///< bursts left
    RequestOrigin origin;
    bool write = false;
    bool activated = false;  ///< a row was opened for it
    bool precharged = false;
  };
  enum Command : unsigned { kRead, kWrite, kPrecharge, kActivate };
  static constexpr std::size_t kCommands = 4;
  using ByCommand = std::array<Cycle, kCommands>;
  struct Bank {
    std::uint32_t oldest = kNone;
    std::uint32_t newest = kNone;
    std::uint32_t hit = kNone;  ///< oldest entry for the open row
    bool open = false;
    std::uint64_t row = 0;
    ByCommand from{};  ///< [command] first clock in which the bank's own timing allows it
  };
  struct Group {
    std::uint64_t banks = 0;
    ByCommand from{};
  };

  static const DramChannelConfig& checked(const DramChannelConfig& config);
  bool aged(const Entry& e, Cycle now) const { return now - e.enqueued > config_.age_cap; }
  void refresh_all_banks(Cycle now);
  std::uint64_t allowed(Command command, Cycle now) const;
  void obey(Cycle now, const DramChoice& choice);
  Cycle next_step(Cycle now, const DramChoice& choice) const;
  Cycle next_for(Command command, std::uint64_t declined) const;
  void reconsider(Cycle now, std::uint32_t bank);
  void wake_banks(Cycle now);
  void book(Cycle clock, std::uint32_t bank);
  void unbook(std::uint32_t bank);
  void issue_column(Cycle now, std::uint32_t entry);
  void issue_row(Cycle now, std::uint32_t entry);
  void find_hit(Bank& bank, std::uint32_t from);
  void set_hit(Bank& bank, std::uint32_t entry);
  void set_oldest(Bank& bank, std::uint32_t entry);
  static QueuedRequest shown(const Entry& e) { return {e.order, e.enqueued, e.origin, e.write}; }
  void remove(std::uint32_t entry);
  void count_queue(Cycle now);

  DramChannelConfig config_;
  std::unique_ptr<DramScheduling> scheduling_;
  DramMapping mapping_;
  std::vector<Group> groups_;  ///< bank groups; empty if they have no timing of their own
  std::vector<Entry> entries_;
  std::vector<std::uint32_t> free_;
  std::vector<Bank> banks_;
  DramQueues queues_;                             ///< the policy's view
  ByCommand from_{};                              ///< [command] first clock in which the channel's timing allows it
  std::array<std::uint64_t, kCommands> ready_{};  ///< [command] banks that want it and whose own timing allows it now
  std::uint64_t timed_ = 0;                       ///< banks that wait for their own timing
  // Timing wheel of the next 64 clocks. A bank due later is booked at the far end and reconsidered there.
  static constexpr Cycle kWheel = 64;
  std::array<std::uint64_t, kWheel> wakes_{};  ///< [clock % kWheel] banks to reconsider
  std::uint64_t wake_clocks_ = 0;              ///< non-empty elements of wakes_
  std::vector<std::uint8_t> wake_;             ///< [bank] index in wakes_, if the bank is in timed_
  RingQueue<Completion> completions_;
  std::size_t queued_ = 0;
  unsigned queued_bursts_ = 0;
  std::uint64_t next_order_ = 0;
  Cycle next_ = kNever;               ///< next clock in which a command can issue
  std::array<Cycle, 4> activated_{};  ///< clocks of the last four activates, a ring buffer (for faw)
  Cycle refresh_at_ = kNever;         ///< clock in which the next refresh is due
  Cycle queue_counted_ = 0;
  DramChannelCounters counters_;
};

}  // namespace grtx::modules
