// SPDX-License-Identifier: Apache-2.0
// Cheap estimate of the work of a ray group (dependent steps, sectors), counted without simulating it. Windows mode
// uses it to extrapolate from the groups that it simulates to all others.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "grtx/rtl_tlm/gpu/gpu_config.h"
#include "grtx/traces/event.h"
#include "grtx/traces/header.h"

namespace grtx::sim {

/// One ray in one traceRay call.
struct LaneWork {
  float steps = 0.0F;         ///< dependent steps, in units of a node fetch that misses the L1
  float sectors = 0.0F;       ///< node sectors requested from the L1
  float dram_sectors = 0.0F;  ///< sectors requested from the DRAM, approximately
};

struct GroupWork {
  double sectors = 0.0;  ///< of all traceRay calls
  double dram_sectors = 0.0;
  double steps = 0.0;  ///< of the longest lane of each call, summed over the calls
};

// Lengths of steps in units of a fetch that misses: a hit takes 20 cycles and a unit's latency, a miss 200 and more; an
// any-hit call waits for its batch (64 cycles) and runs some 70 cycles on the SIMT core. The estimate depends little on
// them, since their error is part of the measured residuals.
inline constexpr float kL1HitStep = 0.15F;
inline constexpr float kAnyHitStep = 0.5F;
inline constexpr double kUsefulCacheShare = 0.7;  ///< of a cache's capacity: the rest holds sectors never requested

/// Mean sectors moved for one entry of a ray's buffers in memory.
struct BufferTraffic {
  float written = 0.0F, read = 0.0F;  ///< for a checkpoint entry; 0 without checkpointing
  float processed = 0.0F;             ///< for a processed k-buffer entry: the Gaussian's records
  BufferTraffic(const traces::Header& header, const GpuConfig& config);
};

/// Counts the work of one group at a time. The lanes of a group step through their events together, against L1 and L2
/// tags of the size of one warp's share of the cache, so that warps with much and with little reuse are told apart.
class WorkCounter {
 public:
  WorkCounter(const traces::Header& header, const GpuConfig& config);
  GroupWork count(const traces::RayGroup& group);

 private:
  /// Tags of nodes, four ways, LRU replacement.
  class Tags {
   public:
    explicit Tags(std::uint64_t nodes);
    void clear() { std::fill(entries_.begin(), entries_.end(), 0); }
    bool access(std::uint32_t unit);  ///< true: a hit; a miss inserts it

   private:
    static constexpr std::size_t kWays = 4;
    std::vector<std::uint32_t> entries_;  ///< unit + 1, by set, most recent first
    std::size_t sets_;
  };
  struct Lane {
    const traces::Event* event = nullptr;
    std::uint32_t left = 0;
    bool after_leaf = false;
    LaneWork work;
  };
  void step(Lane& lane, const traces::RayGroup& group);

  const traces::Header& header_;
  BufferTraffic traffic_;
  bool prefetch_;
  Tags l1_, l2_;
  std::vector<Lane> lanes_;
};

}  // namespace grtx::sim
