// A model of a run at the grain of traceRay calls: the auxiliary variable that explains most of a run's cycles. SMs
// take groups as the work distributor gives them, RT units hold a few warps at a time, lanes step at a common pace that
// the L1 port of the SM or the DRAM of the GPU limits. What it does not know (hit rates, latencies) is three numbers,
// which are fitted to simulated samples. It costs milliseconds, so it is evaluated for the whole trace, and what is
// left between model and simulation is what the sample must estimate.
#pragma once

#include <cstdint>
#include <vector>

#include "grtx/rtl_tlm/estimate/sampled/group_work.h"
#include "grtx/rtl_tlm/run/first_launches.h"

namespace grtx::sim {

/// The resources that the model knows of.
struct ModelMachine {
  unsigned sms = 8;
  unsigned resident_warps = 32;  ///< of an SM
  unsigned call_slots = 8;       ///< warp buffer entries of an SM, all its RT units
  double memory_share = 1.0;     ///< of the whole machine's memory bandwidth
};

struct ModelRates {
  double step_cycles = 300.0;    ///< of a step when nothing is contended
  double sm_sectors = 0.9;       ///< node sectors a cycle of an SM
  double sm_far = 0.6;           ///< far sectors a cycle of an SM: its MSHRs over the time of a miss
  double memory_sectors = 3.0;   ///< far sectors a cycle of the whole machine
  double round_cycles = 2000.0;  ///< between two calls of a warp: blending, its memory accesses
};

struct ModelRun {
  double cycles = 0.0;
  std::vector<double> group_end;  ///< by position
  std::vector<unsigned> group_sm;
};

/// groups: those that run, in launch order. known: launches of the first groups, as they were seen; those of the others
/// follow from free warp slots.
ModelRun run_model(const std::vector<const GroupWork*>& groups, const std::vector<Launch>& known,
                   const ModelMachine& machine, const ModelRates& rates);

}  // namespace grtx::sim
