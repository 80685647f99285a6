// Fast runs of a trace that the model is tied to: three warp buffers on a machine that is otherwise the one asked for.
// They are kept beside the trace.
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "grtx/rtl_tlm/estimate/model/trace_counts.h"
#include "grtx/rtl_tlm/estimate/sampled/warp_model.h"
#include "grtx/rtl_tlm/gpu/gpu_config.h"
#include "grtx/rtl_tlm/run/simulation.h"
#include "grtx/traces/reader.h"

namespace grtx::sim {

/// Keys that the model answers for itself. Another value of any other key is measured: it has anchors of its own.
inline constexpr std::string_view kWarpBufferKey = "rt.warp_buffer.entries", kL1Key = "l1.bytes", kL2Key = "l2.bytes",
                                  kCheckpointLanesKey = "rt.checkpoint.lanes";

struct Anchor {
  unsigned entries = 1;  ///< of the warp buffer
  double cycles = 0.0;
  std::map<std::string, double> statistics;  ///< those that the model gives, of fast mode
};

/// The model tied to one machine but for its warp buffer.
struct TiedModel {
  GpuConfig machine;            ///< warp buffer: any
  std::vector<Anchor> anchors;  ///< ascending entries, at least one
  /// On nominal_rates(): of a step's cycles, so that the smallest warp buffer takes what it took; of all bandwidths, so
  /// that the largest does.
  double latency = 1.0, bandwidth = 1.0;
};

struct StatisticOfModel {
  const char* name;
  const char* unit;
  const char* description;
};
/// Besides gpu.cycles and what follows from it.
const std::vector<StatisticOfModel>& statistics_of_model();

/// Cycles of a machine by the warp model alone.
double modelled_cycles(const TraceCounts& counts, const traces::Header& header, const GpuConfig& config, double latency,
                       double bandwidth);

/// Those kept beside the trace as TRACE.anchors-HASH.json if they are of its content, this machine and this program;
/// else they are run, each in a process, and kept there if the folder may be written.
TiedModel tied_model(const traces::Reader& reader, const TraceCounts& counts, const GpuConfig& machine,
                     const EnergyPricing& price);

}  // namespace grtx::sim
