// SPDX-License-Identifier: Apache-2.0
// Random traffic of a DRAM channel, the same for every implementation of one, and the timing and rows of tests.
#pragma once

#include <algorithm>
#include <cstdint>
#include <ostream>
#include <random>
#include <vector>

#include "grtx/modules/dram/decide/dram_channel.h"

namespace grtx::modules {

inline constexpr DramTiming kTiming{};
inline constexpr std::uint64_t kRow = 2048;
inline constexpr std::uint64_t kSameBank = kRow * 16;  ///< the next row of the same bank

struct DramDone {
  std::uint64_t id;
  Cycle done;
  bool operator==(const DramDone&) const = default;
  friend void PrintTo(const DramDone& d, std::ostream* out) { *out << d.id << " at " << d.done; }
};

struct DramLoad {
  const char* name;
  Cycle age_cap;
  unsigned rows;    ///< of a bank that requests go to
  unsigned writes;  ///< of ten requests
  unsigned pause;   ///< clocks between requests, 0 to this
  friend void PrintTo(const DramLoad& load, std::ostream* out) { *out << load.name; }
};

inline const DramLoad kDramLoads[] = {{"idle", 1024, 8, 2, 200},   {"reads", 1024, 4, 0, 6},
                                      {"mixed", 1024, 8, 3, 8},    {"saturated", 1024, 16, 2, 0},
                                      {"ages_early", 40, 4, 3, 4}, {"ages_and_full", 200, 3, 5, 0}};

inline std::vector<DramDone> done_by(DramChannel& channel) {
  std::vector<DramDone> done;
  for (auto& all = channel.completions(); !all.empty(); all.pop()) done.push_back({all.front().id, all.front().done});
  return done;
}
template <typename Channel>
std::vector<DramDone> done_by(const Channel& channel) {
  return channel.done();
}

/// Sends 3000 requests of a burst, each as soon as the queue has room after its pause. Returns all in order of data.
template <typename Channel>
std::vector<DramDone> run_load(Channel& channel, const DramChannelConfig& config, const DramLoad& load) {
  std::mt19937_64 random(11);
  Cycle clock = 1;
  for (std::uint64_t id = 0; id < 3000; ++id) {
    const std::uint64_t row = random() % load.rows * config.banks + random() % config.banks;
    const std::uint64_t address = row * config.row_bytes + random() % 64 * config.burst_bytes;
    const bool write = random() % 10 < load.writes;
    for (channel.run_until(clock - 1); !channel.can_accept(config.burst_bytes); ++clock) channel.run_until(clock);
    channel.enqueue(clock, id, address, config.burst_bytes, write);
    clock += random() % (load.pause + 1);
    channel.run_until(clock - 1);
  }
  for (; channel.queued() != 0; ++clock) channel.run_until(clock);
  return done_by(channel);
}

}  // namespace grtx::modules
