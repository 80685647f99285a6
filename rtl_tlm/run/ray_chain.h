// SPDX-License-Identifier: Apache-2.0
// The longest chain of dependent work in a trace: no hardware of this configuration can be faster than its longest ray.
#pragma once

#include <optional>

#include "grtx/base/strong.h"
#include "grtx/rtl_tlm/gpu/gpu_config.h"
#include "grtx/rtl_tlm/run/walk_chain.h"
#include "grtx/traces/event.h"
#include "grtx/traces/header.h"

namespace grtx::sim {

/// Least core cycles that the steps of a ray take when everything hits and nothing else runs.
struct ChainLatencies {
  Cycle internal = 0;  ///< node fetched from the L1 and its boxes tested
  Cycle instance = 0;
  Cycle leaf = 0;
  Cycle stack = 1;                ///< an event without a fetch: one turn of the RT scheduler
  Cycle any_hit = 0;              ///< to the SIMT core and back, with the shader's fixed instructions
  Cycle round = 0;                ///< traceRay and blending, without the traversal
  Cycle ray = 0;                  ///< prologue and epilogue
  std::optional<WalkChain> walk;  ///< with rt.traversal = warp: a traversal's time, in which its steps overlap

  ChainLatencies(const GpuConfig& config, const traces::Header& header);
};

struct Chain {
  Cycle ray = 0;   ///< longest single ray
  Cycle warp = 0;  ///< the warp: a round ends for all lanes when its longest lane has finished
};

/// The chains of one group; linear in its events.
Chain measure_chain(const traces::RayGroup& group, const ChainLatencies& latencies);

}  // namespace grtx::sim
