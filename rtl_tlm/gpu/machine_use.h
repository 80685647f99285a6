// Which units a machine has: what the structure that it traverses asks for.
#pragma once

#include <string>

#include "grtx/traces/modes.h"
#include "grtx/traces/node_layout.h"

namespace grtx::sim {

/// Which units the machine must have.
struct MachineUse {
  std::string design = "grtx";                     ///< baseline, sw, hw or grtx: two levels, checkpointing
  bool spheres = false;                            ///< sphere units in place of triangle units
  traces::PopTest pop_test = traces::PopTest::on;  ///< on: stack entries hold a t
  traces::NodeLayout layout = traces::NodeLayout::vulkan_sim;
  bool objects = false;  ///< of sw and grtx: a scene TLAS above, three levels
};

}  // namespace grtx::sim
