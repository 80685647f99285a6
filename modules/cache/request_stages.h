// SPDX-License-Identifier: Apache-2.0
// Where the reads of an SM spend their time: in the queue of the L1, in L1, crossbar, L2 and DRAM. An observer that L1
// and L2 call, if there is one; no hardware, and no cycle depends on it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "grtx/base/declare/named_enum.h"
#include "grtx/base/strong.h"
#include "grtx/modules/kernel/declare.h"
#include "grtx/modules/messages/memory_request.h"

namespace grtx::modules {

enum class MemoryStage : std::uint8_t {
  queue,     ///< from the requester's port until the L1 takes the request
  l1,        ///< its pipeline, waits for its ports, for an MSHR's turn to leave
  crossbar,  ///< both ways
  l2,        ///< its pipeline and queues
  dram,      ///< from an L2 miss until its fill
};
constexpr auto enum_names(MemoryStage) {
  return names_in_order<MemoryStage>({"queue", "l1", "crossbar", "l2", "dram"});
}
inline constexpr std::size_t kStages = kCountOf<MemoryStage>;

/// Who reads: regions in groups.
enum class ReadKind : std::uint8_t { nodes, leaves, shading, checkpoints, stacks };
constexpr auto enum_names(ReadKind) {
  return names_in_order<ReadKind>({"nodes", "leaves", "shading", "checkpoints", "stacks"});
}
inline constexpr std::size_t kReadKinds = kCountOf<ReadKind>;
ReadKind read_kind(Region region);

/// A read that was answered.
struct ServedRead {
  Cycle asked = 0;  ///< sent by the requester
  Cycle since = 0;  ///< what is before is in `cycles`
  std::array<std::uint32_t, kStages> cycles{};
};

/// Cycles of many reads; exact up to kBins.
class StageCycles {
 public:
  static constexpr std::size_t kBins = 8192;
  void add(std::uint64_t cycles);
  double mean() const;
  std::uint64_t sum() const { return sum_; }
  std::uint64_t count() const { return count_; }
  /// The least number of cycles that `share` of the reads do not exceed; the largest if that is kBins or more.
  std::uint64_t percentile(double share) const;

 private:
  std::uint64_t count_ = 0, sum_ = 0, largest_ = 0;
  std::vector<std::uint64_t> bins_;
};

class RequestStages {
 public:
  // An L1's misses are told apart by its SM and the MSHR, which is their tag. Times never go back.
  void waits(unsigned sm, std::uint32_t mshr, Cycle asked, Cycle accepted, bool first);
  void leaves_l1(unsigned sm, std::uint32_t mshr, Cycle now) { miss(sm, mshr).left = now; }
  void enters_l2(unsigned sm, std::uint32_t mshr, Cycle now) { miss(sm, mshr).entered = now; }
  void misses_l2(unsigned sm, std::uint32_t mshr, Cycle now) { miss(sm, mshr).missed = now; }
  void fills_l2(unsigned sm, std::uint32_t mshr, Cycle now) { miss(sm, mshr).filled = now; }
  void leaves_l2(unsigned sm, std::uint32_t mshr, Cycle now) { miss(sm, mshr).replied = now; }
  /// The waiter's share of the miss that now returns; waiters in the order of waits().
  ServedRead fills_l1(unsigned sm, std::uint32_t mshr, std::size_t waiter, Cycle now);
  /// A read is answered in cycle `now`.
  void served(Region region, ServedRead read, Cycle now);

  /// gpu.latency.*: for each kind that was read its number, and by stage mean and 95th percentile.
  void describe(StatisticList& list) const;
  /// Conservation: for each kind the stages' cycles add up to those of the whole reads; "" or what does not hold.
  std::string violation() const;

 private:
  struct Waiter {
    Cycle asked = 0, accepted = 0;
  };
  struct Miss {
    Cycle allocated = 0, left = 0, entered = 0, missed = 0, filled = 0, replied = 0;
    std::vector<Waiter> waiters;
  };
  struct Reads {
    StageCycles whole;
    std::array<StageCycles, kStages> stages;
  };
  Miss& miss(unsigned sm, std::uint32_t mshr);

  std::vector<std::vector<Miss>> misses_;  ///< [sm][mshr]
  std::array<Reads, kReadKinds> reads_;
};

}  // namespace grtx::modules
