// The first launches of a run. Which SM gets which group decides how unequal the SMs' work is, and with it when the run
// ends; the first launches follow from a few thousand cycles, which are simulated on the whole machine.
#pragma once

#include <vector>

#include "rtl_tlm/gpu_config.h"
#include "rtl_tlm/sampled/warp_model.h"
#include "traces/io.h"

namespace grtx::tlm {

/// Launches by position, those within the first `cycles` core cycles (at most what the trace has). Elaborates SystemC:
/// call it in a ChildProcess.
std::vector<Launch> first_launches(const traces::Reader& reader, const GpuConfig& config, Cycle cycles);

}  // namespace grtx::tlm
