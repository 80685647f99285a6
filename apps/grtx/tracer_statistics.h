// The tracer's counters under their published names.
#pragma once

#include "grtx/frontend/accel/acceleration_structure.h"
#include "grtx/frontend/scene/scene.h"
#include "grtx/frontend/tracer/secondary_plan.h"
#include "grtx/frontend/tracer/tracer.h"
#include "grtx/modules/kernel/statistics.h"
#include "grtx/traces/writer.h"

namespace grtx::sim {

/// tracer.* and accel.* (deterministic).
modules::StatisticList tracer_statistics(const frontend::Scene& scene, const frontend::AccelerationStructure& accel,
                                         const frontend::RenderResult& result);
/// tracer.secondary.*: the share of the secondary rays in tracer.*; all zero without objects.
void add_secondary_statistics(modules::StatisticList& list, const frontend::SecondaryPlan& plan,
                              const frontend::RenderResult& result);
/// trace.* of a finished trace.
void add_trace_statistics(modules::StatisticList& list, const traces::Writer& writer);
/// tracer.wall_seconds, tracer.rays_per_second, accel.build_seconds: depend on the host.
modules::StatisticList tracer_host_statistics(const frontend::AccelerationStructure& accel,
                                              const frontend::RenderResult& result);

}  // namespace grtx::sim
