// SPDX-License-Identifier: Apache-2.0
// Factories of the units that also exist as RTL, and the configurations that the RTL supports.
#pragma once

#include <cstdint>
#include <memory>

#include "grtx/modules/rt_unit/checkpoint/checkpoint_if.h"
#include "grtx/modules/rt_unit/rt_unit_if.h"
#include "grtx/modules/rt_unit/rt_unit_parts.h"

namespace grtx::sim {

/// Whether this build includes the Verilated blocks.
bool has_rtl();

/// Largest configuration of the Verilated checkpoint unit.
struct CheckpointRtlLimits {
  static constexpr unsigned kLanes = 32, kWriteQueue = 64, kWarps = 32;
  static constexpr std::uint64_t kEntries = 65535;  ///< per buffer
};
/// Largest configuration of the Verilated ray-box and ray-transform units. A pipeline with fewer cycles than its steps
/// is built with a single register.
struct IntersectionRtlLimits {
  static constexpr unsigned kCount = 8, kWarps = 32, kInterval = 127, kBoxes = 8;
  static constexpr unsigned kDelay = 63;  ///< latency that the strap pins can add, in cycles
  static constexpr unsigned kLatency = 1 + kDelay;
  static constexpr unsigned kBoxSteps = 13, kTransformSteps = 6;
  // Variants with several registers behind the long steps: their latency, and the most pipelines.
  static constexpr unsigned kBoxDeep = 34, kTransformDeep = 45, kDeepCount = 4;
};

/// First key under rt. whose value the RTL does not support, and the rule; an empty key means supported.
struct RtlRefusal {
  const char* key = "";
  const char* rule = "";
};
RtlRefusal checkpoint_rtl_refusal(const modules::RtUnitConfig& config);
RtlRefusal box_rtl_refusal(const modules::RtUnitConfig& config);
RtlRefusal transform_rtl_refusal(const modules::RtUnitConfig& config);
/// The first refusal among the units that the configuration selects as RTL.
RtlRefusal rtl_refusal(const modules::RtUnitConfig& config);

struct RtlBenchOptions {
  /// If not 0: seed for random extra edges without a transfer, and for random values on pins that are not valid.
  std::uint64_t disturbance = 0;
  bool faulty_block =
      false;           ///< use the block with fault injection (CHECKPOINT_FAULTS, INTERSECTION_FAULTS in the RTL)
  unsigned fault = 0;  ///< injected fault: 0 none, 1 comparison, 2 lost entry, 3 off by one
};

/// Construct a unit as RTL. Throw Error without has_rtl(), and for configurations that the RTL does not support.
std::unique_ptr<modules::CheckpointModule> make_checkpoint_rtl(const char* name, const modules::RtUnitContext& rt,
                                                               const RtlBenchOptions& options = {});
std::unique_ptr<modules::IntersectionModule> make_box_rtl(const char* name, const modules::RtUnitContext& rt,
                                                          const RtlBenchOptions& options = {});
std::unique_ptr<modules::IntersectionModule> make_transform_rtl(const char* name, const modules::RtUnitContext& rt,
                                                                const RtlBenchOptions& options = {});

/// Sets the factories in `parts` for the units that the configuration selects as RTL, unless already set.
void use_rtl(const modules::RtUnitConfig& config, modules::RtUnitParts& parts);

}  // namespace grtx::sim
