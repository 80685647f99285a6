// One DRAM channel: banks with open rows and command timing; a policy schedules. Plain C++, no SystemC.
// GPGPU-Sim's GDDR model as configured by Vulkan-Sim; bank groups and refresh where configured (docs/model/dram.md).
#pragma once

#include <array>
#include <cstdint>
#include <iosfwd>
#include <memory>
#include <vector>

#include "grtx/base/state_bytes.h"
#include "grtx/modules/dram/decide/dram_config.h"
#include "grtx/modules/dram/decide/dram_counters.h"
#include "grtx/modules/dram/decide/dram_mapping.h"
#include "grtx/modules/kernel/clock_domain.h"
#include "grtx/modules/kernel/ring_queue.h"

namespace grtx::modules {

/// Commands follow from the requests alone, so the channel simulates ahead lazily: run_until() executes everything up
/// to a clock, jumping over clocks in which nothing can issue. At most one row and one column command a clock.
class DramChannel {
 public:
  struct Completion {
    std::uint64_t id = 0;
    Cycle done = 0;  ///< clock after the last data clock
  };

  /// Throws Error for an impossible configuration.
  explicit DramChannel(const DramChannelConfig& config);
  /// scheduling: in place of the one that config names; nullptr: that one.
  DramChannel(const DramChannelConfig& config, std::unique_ptr<DramScheduling> scheduling);

  unsigned bursts(unsigned bytes) const { return (bytes + config_.burst_bytes - 1) / config_.burst_bytes; }
  bool can_accept(unsigned bytes) const { return queued_bursts_ + bursts(bytes) <= config_.queue; }
  /// A request that may issue from clock `now` on; run_until(now - 1) must have run, can_accept() must hold. address:
  /// channel-local bytes, within one row. id: returned with the completion. origin: shown to the policy.
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
  /// Executes one clock. run_until() calls it for the clocks in which a command can issue; for others it does nothing.
  void step(Cycle now);
  /// Executes ahead until the queue has room for `bytes`; returns the clock of that command. Nothing may be enqueued
  /// for an earlier clock afterwards.
  Cycle run_until_room(unsigned bytes);

  /// Completions in order of `done`, which is the order of the data bus.
  RingQueue<Completion>& completions() { return completions_; }
  /// No completion that is not in completions() yet can be done before this clock; kNever when nothing is queued.
  Cycle completion_bound() const;
  Cycle next_command() const { return next_; }
  /// Another launch, with clocks counted from 0: as built, with rows open as they are, or all closed.
  void restart(bool keep_rows);
  /// What restart(true) keeps. load(): as built.
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
  /// State that hardware keeps for the scheduling, a bank.
  unsigned scheduling_bits_per_bank() const { return scheduling_->bits_per_bank(); }
  void dump_state(std::ostream& out) const;

 private:
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};

  struct Entry {
    std::uint64_t id = 0;
    std::uint64_t row = 0;
    std::uint64_t order = 0;  ///< of arrival in the channel
    Cycle enqueued = 0;
    std::uint32_t newer = kNone;  ///< neighbours in the bank's list
    std::uint32_t older = kNone;
    std::uint32_t bank = 0;
    unsigned remaining = 0;  ///< bursts to go
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
    std::uint32_t hit = kNone;  ///< oldest entry of the open row
    bool open = false;
    std::uint64_t row = 0;
    ByCommand from{};  ///< first clock in which its own timing allows a command
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
  std::vector<Group> groups_;  ///< none when they have no times of their own
  std::vector<Entry> entries_;
  std::vector<std::uint32_t> free_;
  std::vector<Bank> banks_;
  DramQueues queues_;                             ///< shown to the policy
  ByCommand from_{};                              ///< first clock in which the timing that banks share allows a command
  std::array<std::uint64_t, kCommands> ready_{};  ///< busy banks, by the commands that their own timing allows now
  std::uint64_t timed_ = 0;                       ///< of these, those that wait for their time
  // When: by the clock modulo 64, later than the last one executed. What is farther away is looked at in between.
  static constexpr Cycle kWheel = 64;
  std::array<std::uint64_t, kWheel> wakes_{};  ///< banks
  std::uint64_t wake_clocks_ = 0;              ///< which of wakes_ are not empty
  std::vector<std::uint8_t> wake_;             ///< of a bank in timed_, in wakes_
  RingQueue<Completion> completions_;
  std::size_t queued_ = 0;
  unsigned queued_bursts_ = 0;
  std::uint64_t next_order_ = 0;
  Cycle next_ = kNever;               ///< next clock at which a command can issue
  std::array<Cycle, 4> activated_{};  ///< the last activates, by their number modulo 4
  Cycle refresh_at_ = kNever;         ///< the next is due
  Cycle queue_counted_ = 0;
  DramChannelCounters counters_;
};

}  // namespace grtx::modules
