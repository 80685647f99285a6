// Machines on which samples run: a part of the whole machine, so that a sample meets the contention of the whole run.
#pragma once

#include "grtx/rtl_tlm/estimate/sampled/warp_model.h"
#include "grtx/rtl_tlm/gpu/gpu_config.h"

namespace grtx::sim {

struct ScaledMachine {
  GpuConfig config;
  ModelMachine model;
};

/// How the model sees a machine.
ModelMachine model_of(const GpuConfig& config);
/// Rates of the model that follow from the configuration alone.
ModelRates nominal_rates(const GpuConfig& config);

/// Half an SM: half the warp buffer, half the L1, and the share of L2 and DRAM that half an SM has. A sample on it runs
/// as the run does while all SMs are busy.
ScaledMachine half_sm(const GpuConfig& config);
/// One SM with twice an SM's share of L2 and DRAM: a sample on it runs as the run does when some SMs have no work left.
ScaledMachine idle_neighbours(const GpuConfig& config);

/// `config` with one SM and `share` of the L2 and of the DRAM bandwidth. Channels are taken away as far as whole ones
/// can be; what remains lowers the DRAM's clock, with its latencies kept in nanoseconds and banks and queues in
/// proportion.
GpuConfig one_sm(const GpuConfig& config, double share);

}  // namespace grtx::sim
