// Units of the RT unit that exist as RTL, too: who makes them, and for which configurations.
#pragma once

#include <cstdint>
#include <memory>

#include "grtx/modules/rt_unit/checkpoint_if.h"
#include "grtx/modules/rt_unit/rt_unit.h"
#include "grtx/modules/rt_unit/rt_unit_parts.h"

namespace grtx::sim {

/// Whether this build has the Verilated blocks.
bool has_rtl();

/// What the Verilated checkpoint unit is built for.
struct CheckpointRtlLimits {
  static constexpr unsigned kLanes = 32, kWriteQueue = 64, kWarps = 32;
  static constexpr std::uint64_t kEntries = 65535;  ///< of a buffer
};
/// And the ray-box and the ray-transform unit. A pipeline of fewer cycles than its steps is built with one register.
struct IntersectionRtlLimits {
  static constexpr unsigned kCount = 8, kWarps = 32, kInterval = 127, kBoxes = 8;
  static constexpr unsigned kDelay = 63;  ///< cycles that the straps can add
  static constexpr unsigned kLatency = 1 + kDelay;
  static constexpr unsigned kBoxSteps = 13, kTransformSteps = 6;
  // With several registers behind the long steps; of at most so many pipelines.
  static constexpr unsigned kBoxDeep = 34, kTransformDeep = 45, kDeepCount = 4;
};

/// First key under rt. that the RTL of a unit does not have, and the rule; an empty key: none.
struct RtlRefusal {
  const char* key = "";
  const char* rule = "";
};
RtlRefusal checkpoint_rtl_refusal(const modules::RtUnitConfig& config);
RtlRefusal box_rtl_refusal(const modules::RtUnitConfig& config);
RtlRefusal transform_rtl_refusal(const modules::RtUnitConfig& config);
/// Why a unit that the configuration wants as RTL cannot be RTL, if there is one.
RtlRefusal rtl_refusal(const modules::RtUnitConfig& config);

struct RtlBenchOptions {
  /// Other than 0: edges without a transfer in between, and arbitrary values on pins that carry nothing, by this seed.
  std::uint64_t disturbance = 0;
  bool faulty_block = false;  ///< the one that can be made wrong (CHECKPOINT_FAULTS and INTERSECTION_FAULTS in the RTL)
  unsigned fault = 0;         ///< of that block: 0 none, 1 comparison, 2 lost entry, 3 one off
};

/// A unit as RTL. Throw Error without has_rtl(), and for what it does not have.
std::unique_ptr<modules::CheckpointModule> make_checkpoint_rtl(const char* name, const modules::RtUnitContext& rt,
                                                               const RtlBenchOptions& options = {});
std::unique_ptr<modules::IntersectionModule> make_box_rtl(const char* name, const modules::RtUnitContext& rt,
                                                          const RtlBenchOptions& options = {});
std::unique_ptr<modules::IntersectionModule> make_transform_rtl(const char* name, const modules::RtUnitContext& rt,
                                                                const RtlBenchOptions& options = {});

/// Units that the configuration wants as RTL, unless somebody else makes them.
void use_rtl(const modules::RtUnitConfig& config, modules::RtUnitParts& parts);

}  // namespace grtx::sim
