// SPDX-License-Identifier: Apache-2.0
#include "grtx/rtl_tlm/rtl/rtl_units.h"

#include "grtx/base/error.h"

namespace grtx::sim {

using modules::CheckpointConfig;
using modules::CheckpointModule;
using modules::IntersectionModule;
using modules::RtUnitConfig;
using modules::RtUnitContext;
using modules::RtUnitParts;
using modules::TrafficCharging;
using modules::UnitImplementation;

#ifdef GRTX_WITH_VERILATOR
std::unique_ptr<CheckpointModule> make_verilated_checkpoint_unit(const char* name, const RtUnitContext& rt,
                                                                 const RtlBenchOptions& options);
std::unique_ptr<IntersectionModule> make_verilated_ray_box(const char* name, const RtUnitContext& rt,
                                                           const RtlBenchOptions& options);
std::unique_ptr<IntersectionModule> make_verilated_ray_transform(const char* name, const RtUnitContext& rt,
                                                                 const RtlBenchOptions& options);
bool has_rtl() { return true; }
#else
namespace {
std::unique_ptr<CheckpointModule> make_verilated_checkpoint_unit(const char*, const RtUnitContext&,
                                                                 const RtlBenchOptions&) {
  return nullptr;
}
std::unique_ptr<IntersectionModule> make_verilated_ray_box(const char*, const RtUnitContext&, const RtlBenchOptions&) {
  return nullptr;
}
std::unique_ptr<IntersectionModule> make_verilated_ray_transform(const char*, const RtUnitContext&,
                                                                 const RtlBenchOptions&) {
  return nullptr;
}
}  // namespace
bool has_rtl() { return false; }
#endif

namespace {

constexpr const char* kNoVerilator = "is rtl, but this build found no Verilator (own-rtl.md)";

void require_none(const RtlRefusal& refusal) {
  if (*refusal.key != 0) throw Error("configuration", std::string("rt.") + refusal.key, refusal.rule);
}

}  // namespace

RtlRefusal checkpoint_rtl_refusal(const RtUnitConfig& rt) {
  const CheckpointConfig& config = rt.checkpoint;
  using Limits = CheckpointRtlLimits;
  constexpr const char* kSystemCOnly = "is not in the RTL: needs rt.checkpoint.implementation = tlm";
  if (!has_rtl()) return {"checkpoint.implementation", kNoVerilator};
  if (config.traffic != TrafficCharging::charged) return {"checkpoint.traffic", kSystemCOnly};
  if (config.lanes > Limits::kLanes) return {"checkpoint.lanes", "must be at most 32 with implementation = rtl"};
  if (config.write_queue > Limits::kWriteQueue) {
    return {"checkpoint.write_queue", "must be at most 64 with rt.checkpoint.implementation = rtl"};
  }
  if (rt.warp_buffer.entries > Limits::kWarps) {
    return {"warp_buffer.entries", "must be at most 32 with rt.checkpoint.implementation = rtl"};
  }
  return {};
}

RtlRefusal box_rtl_refusal(const RtUnitConfig& rt) {
  using Limits = IntersectionRtlLimits;
  if (!has_rtl()) return {"box.implementation", kNoVerilator};
  if (rt.ray_box.count > Limits::kCount) return {"box.count", "must be at most 8 with rt.box.implementation = rtl"};
  if (rt.ray_box.latency > Limits::kLatency) {
    return {"box.latency", "must be at most 64 with rt.box.implementation = rtl"};
  }
  if (rt.ray_box.interval > Limits::kInterval) {
    return {"box.interval", "must be at most 127 with rt.box.implementation = rtl"};
  }
  if (rt.warp_buffer.entries > Limits::kWarps) {
    return {"warp_buffer.entries", "must be at most 32 with rt.box.implementation = rtl"};
  }
  return {};
}

RtlRefusal transform_rtl_refusal(const RtUnitConfig& rt) {
  using Limits = IntersectionRtlLimits;
  if (!has_rtl()) return {"transform.implementation", kNoVerilator};
  if (rt.ray_transform.count > Limits::kCount) {
    return {"transform.count", "must be at most 8 with rt.transform.implementation = rtl"};
  }
  if (rt.ray_transform.latency > Limits::kLatency) {
    return {"transform.latency", "must be at most 64 with rt.transform.implementation = rtl"};
  }
  if (rt.ray_transform.interval > Limits::kInterval) {
    return {"transform.interval", "must be at most 127 with rt.transform.implementation = rtl"};
  }
  if (rt.warp_buffer.entries > Limits::kWarps) {
    return {"warp_buffer.entries", "must be at most 32 with rt.transform.implementation = rtl"};
  }
  return {};
}

RtlRefusal rtl_refusal(const RtUnitConfig& rt) {
  RtlRefusal refusal;
  if (rt.checkpoint.implementation == UnitImplementation::rtl) refusal = checkpoint_rtl_refusal(rt);
  if (*refusal.key == 0 && rt.box_implementation == UnitImplementation::rtl) refusal = box_rtl_refusal(rt);
  if (*refusal.key == 0 && rt.transform_implementation == UnitImplementation::rtl) refusal = transform_rtl_refusal(rt);
  return refusal;
}

std::unique_ptr<CheckpointModule> make_checkpoint_rtl(const char* name, const RtUnitContext& rt,
                                                      const RtlBenchOptions& options) {
  require_none(checkpoint_rtl_refusal(rt.config));
  if (rt.header.checkpoint_order == traces::CheckpointOrder::lifo) {
    throw Error("trace", "header", "checkpoint order lifo is not in the RTL: needs rt.checkpoint.implementation = tlm");
  }
  if (rt.header.checkpoint_bins != 0) {
    throw Error("trace", "header", "checkpoint bins are not in the RTL: needs rt.checkpoint.implementation = tlm");
  }
  if (rt.header.checkpoint_capacity > CheckpointRtlLimits::kEntries) {
    throw Error("trace", "header", "checkpoint_capacity must be at most 65535 with rt.checkpoint.implementation = rtl");
  }
  return make_verilated_checkpoint_unit(name, rt, options);
}

std::unique_ptr<IntersectionModule> make_box_rtl(const char* name, const RtUnitContext& rt,
                                                 const RtlBenchOptions& options) {
  require_none(box_rtl_refusal(rt.config));
  if (rt.header.node_sizes().decoder_priced()) {
    throw Error("trace", "header",
                "the RTL decodes no boxes, but the node layout needs it: needs rt.box.implementation = tlm");
  }
  if (rt.header.bvh_width > IntersectionRtlLimits::kBoxes) {
    throw Error("trace", "header", "bvh_width must be at most 8 with rt.box.implementation = rtl");
  }
  return make_verilated_ray_box(name, rt, options);
}

std::unique_ptr<IntersectionModule> make_transform_rtl(const char* name, const RtUnitContext& rt,
                                                       const RtlBenchOptions& options) {
  require_none(transform_rtl_refusal(rt.config));
  if (rt.header.node_sizes().coded_transforms()) {
    throw Error("trace", "header",
                "the RTL decodes no transforms, but the node layout needs it: needs rt.transform.implementation = tlm");
  }
  return make_verilated_ray_transform(name, rt, options);
}

void use_rtl(const RtUnitConfig& config, RtUnitParts& parts) {
  if (config.checkpoint.implementation == UnitImplementation::rtl && !parts.checkpoint_unit) {
    parts.checkpoint_unit = [](const char* name, const RtUnitContext& rt) { return make_checkpoint_rtl(name, rt); };
  }
  if (config.box_implementation == UnitImplementation::rtl && !parts.ray_box) {
    parts.ray_box = [](const char* name, const RtUnitContext& rt) { return make_box_rtl(name, rt); };
  }
  if (config.transform_implementation == UnitImplementation::rtl && !parts.ray_transform) {
    parts.ray_transform = [](const char* name, const RtUnitContext& rt) { return make_transform_rtl(name, rt); };
  }
}

}  // namespace grtx::sim
