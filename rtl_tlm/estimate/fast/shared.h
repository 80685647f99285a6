// What the units of all SMs share in fast mode: the configuration, the trace's header, time and the memory behind the
// L1s.
#pragma once

#include <cstdint>
#include <memory>

#include "grtx/modules/messages/memory_map.h"
#include "grtx/modules/rt_unit/decide/node_traffic.h"
#include "grtx/modules/rt_unit/decide/warp_selection.h"
#include "grtx/modules/simt/decide/shader_program.h"
#include "grtx/rtl_tlm/estimate/fast/agenda.h"
#include "grtx/rtl_tlm/estimate/fast/fast_memory.h"
#include "grtx/rtl_tlm/gpu/gpu_config.h"

namespace grtx::sim::fast {

struct Shared {
  /// stride: one in so many of a lane's events takes time, a power of two.
  Shared(const GpuConfig& config, const traces::Header& header, std::uint64_t eviction_entries, unsigned stride);

  std::uint64_t draw() {
    drawn = drawn * 6364136223846793005u + 1442695040888963407u;  // Knuth's MMIX
    return drawn >> 33;
  }

  GpuConfig config;
  const traces::Header& header;
  modules::NodeTraffic traffic;
  modules::MemoryMap map;
  unsigned stride;
  Agenda agenda;
  FastMemory memory;
  std::unique_ptr<modules::WarpSelection> selection;
  modules::ShaderPhase phase;  ///< that is being executed
  std::uint64_t drawn;         ///< state of draw()
};

}  // namespace grtx::sim::fast
