// Private store of an SM: keeps the first entries of every resident ray's k-buffer and eviction buffer in an SRAM
// beside the SIMT core, one bank per lane, instead of in memory. Not in the paper, where they are in global memory.
// With `insertion` each bank inserts hits into its k-buffers itself, and no any-hit shader runs.
// Cost: 8 B per entry, lane and warp slot. docs/model/private_store.md has the timing to the cycle.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <string>

#include "grtx/base/strong.h"
#include "grtx/modules/kernel/declare.h"
#include "grtx/modules/messages/lane_loop.h"
#include "grtx/modules/messages/warp_messages.h"

namespace grtx::modules {

/// Free of SystemC: accesses are reserved in call order. Lane l of any warp uses bank l, so a warp's access to one
/// entry per lane never has bank conflicts.
class PrivateStore {
 public:
  static constexpr unsigned kEntryBytes = 8;  ///< t and id

  struct Config {
    unsigned k_buffer_entries = 0;  ///< per ray; further entries are in memory
    unsigned eviction_entries = 0;  ///< per ray; further entries are in memory
    unsigned latency = 19;
    unsigned lane_bytes = 4;  ///< bank width, bytes per cycle, 4 or 8
    bool insertion = false;   ///< the banks insert hits, without a shader
    unsigned insertion_latency = 4;
    void parameters(ParameterList& list) {
      list.add("k_buffer_entries", k_buffer_entries, {0, 4096}, "entries",
               "of each ray's k-buffer in an SRAM beside the SIMT core; those behind lie in memory", kOurs)
          .came_later();
      list.add("eviction_entries", eviction_entries, {0, 4096}, "entries", "the same for eviction buffers", kOurs)
          .came_later();
      list.add("latency", latency, {1, kMaxLatency}, "cycles", "from a read's last cycle at the banks to its data",
               from_public("Jia et al. 2018: shared memory of Volta"))
          .came_later();
      list.add("lane_bytes", lane_bytes, {4, 8}, "B/cycle",
               "width of a lane's bank, 4 or 8: an entry of 8 B takes two cycles or one",
               from_public("CUDA programming guide: 32 banks of 4 B"))
          .came_later();
      list.add("insertion", insertion, "each bank inserts hits into its lane's k-buffers; no any-hit shader runs",
               kOurs)
          .came_later();
      list.add("insertion_latency", insertion_latency, {1, kMaxLatency}, "cycles",
               "from the last access of an insertion at its bank to the answer", assumed("a comparison and a register"))
          .came_later();
      list.rule(
          "lane_bytes", [this] { return lane_bytes == 4 || lane_bytes == 8; }, "must be 4 or 8");
      list.rule(
          "insertion", [this] { return !insertion || k_buffer_entries > 0; },
          "needs k-buffers on chip: simt.private_store.k_buffer_entries");
    }
    /// Entries per ray in the store.
    unsigned entries() const { return k_buffer_entries + eviction_entries; }
    /// Cycles that the banks are busy with an access to one entry per lane.
    unsigned cycles() const { return kEntryBytes / lane_bytes; }
  };

  struct Counters {
    std::uint64_t reads = 0, writes = 0, wait_cycles = 0;
    std::uint64_t insertions = 0, insertion_words = 0, insertion_wait = 0;
    static const CounterTable<Counters>& table();
    void add(const Counters& other) { table().add(*this, other); }
  };

  explicit PrivateStore(const Config& config) : config_(config) {}

  /// Reserves `count` reads of a warp after all earlier reservations. Returns the cycle in which the last data are
  /// available: max(now, free) + count x cycles() - 1 + latency.
  Cycle read(std::uint64_t count, Cycle now) {
    counters_.reads += count;
    return reserve(count, now) - 1 + config_.latency;
  }
  /// Reserves writes. Nobody waits for them, since later reads are reserved after them.
  void write(std::uint64_t count, Cycle now) {
    counters_.writes += count;
    reserve(count, now);
  }
  /// Inserts a lane's hit into the k-buffer in its bank with `accesses` entry reads and writes, after the bank's
  /// earlier reservations and in parallel to other banks. Returns the cycle in which the answer is available: max(now,
  /// free) + accesses x cycles() - 1 + insertion_latency; without an access now + insertion_latency.
  Cycle insert(unsigned lane, std::uint32_t accesses, Cycle now) {
    ++counters_.insertions;
    if (accesses == 0) return now + config_.insertion_latency;
    Cycle& bank = bank_free_[lane];
    const Cycle begin = std::max({now, free_, bank});
    const Cycle words = Cycle{accesses} * config_.cycles();
    counters_.insertion_wait += begin - now;
    counters_.insertion_words += words;
    bank = begin + words;
    banks_free_ = std::max(banks_free_, bank);
    return bank - 1 + config_.insertion_latency;
  }
  /// Inserts the hits of several lanes of a warp. Returns the cycle of the last answer.
  Cycle insert(LaneMask lanes, const std::array<std::uint32_t, kMaxLanes>& accesses, Cycle now) {
    Cycle last = now;
    for_each_bit(lanes, [&](unsigned lane) { last = std::max(last, insert(lane, accesses[lane], now)); });
    return last;
  }
  /// First cycle from which all banks are free.
  Cycle free_from() const { return std::max(free_, banks_free_); }
  const Config& config() const { return config_; }
  const Counters& counters() const { return counters_; }

 private:
  Cycle reserve(std::uint64_t count, Cycle now) {
    if (count == 0) return now + 1;  // only the latency remains
    const Cycle begin = std::max(free_from(), now);
    counters_.wait_cycles += begin - now;
    return free_ = begin + count * config_.cycles();
  }

  Config config_;
  Cycle free_ = 0;                            ///< end of the reservations of all banks together
  std::array<Cycle, kMaxLanes> bank_free_{};  ///< [bank] end of its insertions
  Cycle banks_free_ = 0;                      ///< latest of bank_free_
  Counters counters_;
};

}  // namespace grtx::modules
