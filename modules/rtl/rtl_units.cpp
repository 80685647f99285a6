#include "grtx/modules/rtl/rtl_units.h"

#include "grtx/base/error.h"

namespace grtx::modules {

#ifdef GRTX_WITH_VERILATOR
std::unique_ptr<CheckpointModule> make_verilated_checkpoint_unit(const char* name, const RtUnitContext& rt,
                                                                 const RtlBenchOptions& options);
bool has_rtl() { return true; }
#else
namespace {
std::unique_ptr<CheckpointModule> make_verilated_checkpoint_unit(const char*, const RtUnitContext&,
                                                                 const RtlBenchOptions&) {
  return nullptr;
}
}  // namespace
bool has_rtl() { return false; }
#endif

RtlRefusal checkpoint_rtl_refusal(const RtUnitConfig& rt) {
  const CheckpointConfig& config = rt.checkpoint;
  using Limits = CheckpointRtlLimits;
  constexpr const char* kSystemCOnly = "is not in the RTL: needs rt.checkpoint.implementation = tlm";
  if (!has_rtl()) return {"checkpoint.implementation", "is rtl, but this build found no Verilator (own-rtl.md)"};
  if (config.forward != CheckpointForward::rewrite) return {"checkpoint.forward", kSystemCOnly};
  if (config.read_ahead > 0) return {"checkpoint.read_ahead", kSystemCOnly};
  if (config.prefetch_nodes) return {"checkpoint.prefetch_nodes", kSystemCOnly};
  if (config.store.entries > 0) return {"private_store.checkpoint_entries", kSystemCOnly};
  if (config.lanes > Limits::kLanes) return {"checkpoint.lanes", "must be at most 32 with implementation = rtl"};
  if (config.write_queue > Limits::kWriteQueue) {
    return {"checkpoint.write_queue", "must be at most 64 with rt.checkpoint.implementation = rtl"};
  }
  if (rt.warp_buffer.entries > Limits::kWarps) {
    return {"warp_buffer.entries", "must be at most 32 with rt.checkpoint.implementation = rtl"};
  }
  return {};
}

std::unique_ptr<CheckpointModule> make_checkpoint_rtl(const char* name, const RtUnitContext& rt,
                                                      const RtlBenchOptions& options) {
  if (const RtlRefusal refusal = checkpoint_rtl_refusal(rt.config); *refusal.key != 0) {
    throw Error("configuration", std::string("rt.") + refusal.key, refusal.rule);
  }
  if (rt.header.checkpoint_order == traces::CheckpointOrder::lifo) {
    throw Error("trace", "header", "checkpoint order lifo is not in the RTL: needs rt.checkpoint.implementation = tlm");
  }
  if (rt.header.checkpoint_capacity > CheckpointRtlLimits::kEntries) {
    throw Error("trace", "header", "checkpoint_capacity must be at most 65535 with rt.checkpoint.implementation = rtl");
  }
  return make_verilated_checkpoint_unit(name, rt, options);
}

}  // namespace grtx::modules
