// Units of the RT unit that exist as RTL, too: who makes them, and for which configurations.
#pragma once

#include <cstdint>
#include <memory>

#include "grtx/modules/rt_unit/checkpoint_if.h"
#include "grtx/modules/rt_unit/rt_unit.h"
#include "grtx/modules/rt_unit/rt_unit_parts.h"

namespace grtx::modules {

/// Whether this build has the Verilated blocks.
bool has_rtl();

/// What the Verilated checkpoint unit is built for.
struct CheckpointRtlLimits {
  static constexpr unsigned kLanes = 32, kWriteQueue = 64, kWarps = 32;
  static constexpr std::uint64_t kEntries = 65535;  ///< of a buffer
};

/// First key under rt. that the RTL of the checkpoint unit does not have, and the rule; an empty key: none.
struct RtlRefusal {
  const char* key = "";
  const char* rule = "";
};
RtlRefusal checkpoint_rtl_refusal(const RtUnitConfig& config);

struct RtlBenchOptions {
  /// Other than 0: edges without a transfer in between, and arbitrary values on pins that carry nothing, by this seed.
  std::uint64_t disturbance = 0;
  bool faulty_block = false;  ///< the one that can be made wrong (CHECKPOINT_FAULTS in checkpoint_unit.sv)
  unsigned fault = 0;         ///< of that block: 0 none, 1 comparison, 2 lost entry, 3 offset
};

/// The checkpoint unit as RTL. Throws Error without has_rtl(), and for what it does not have.
std::unique_ptr<CheckpointModule> make_checkpoint_rtl(const char* name, const RtUnitContext& rt,
                                                      const RtlBenchOptions& options = {});

}  // namespace grtx::modules
