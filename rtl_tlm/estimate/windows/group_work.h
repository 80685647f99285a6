// What the groups of a trace ask of the hardware, counted without simulating it: the auxiliary variables of the
// windows.
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
  float steps = 0.0F;    ///< dependent steps, in units of a node fetch that misses the L1
  float sectors = 0.0F;  ///< node sectors asked of the L1
  float far = 0.0F;      ///< sectors asked of the DRAM, about
};

struct GroupWork {
  double sectors = 0.0;  ///< of all traceRay calls
  double far = 0.0;
  double steps = 0.0;  ///< longest lane of each call, added up
};

// In units of a fetch that misses: a hit takes 20 cycles and a unit's latency, a miss 200 and more; an any-hit call
// waits for its batch (64 cycles) and runs some 70 cycles on the SIMT core. The estimate does not depend on them much:
// what they leave unexplained is part of the measured residuals.
inline constexpr float kNearStep = 0.15F;
inline constexpr float kAnyHitStep = 0.5F;
inline constexpr double kUsefulShare = 0.7;  ///< of a cache's lines: the rest holds sectors that nobody asked for

/// Sectors that an entry of the private buffers takes to be moved.
struct TrafficOfEntries {
  float written = 0.0F, read = 0.0F;  ///< of a checkpoint; 0 without checkpointing
  float processed = 0.0F;             ///< of a k-buffer entry that is looked at: the Gaussian's records
  TrafficOfEntries(const traces::Header& header, const GpuConfig& config);
};

/// Counts groups, one after the other. Each is walked with its lanes in step through caches of its own, as large as a
/// warp's share of the L1 and of the L2, so that warps that reuse much and warps that do not are told apart.
class WorkCounter {
 public:
  WorkCounter(const traces::Header& header, const GpuConfig& config);
  GroupWork count(const traces::RayGroup& group);

 private:
  /// Tags of nodes, four ways, least recently used out first.
  class Tags {
   public:
    explicit Tags(std::uint64_t nodes);
    void clear() { std::fill(entries_.begin(), entries_.end(), 0); }
    bool touch(std::uint32_t unit);  ///< whether it was there; it is afterwards

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
  TrafficOfEntries traffic_;
  bool prefetch_;
  Tags l1_, l2_;
  std::vector<Lane> lanes_;
};

}  // namespace grtx::sim
