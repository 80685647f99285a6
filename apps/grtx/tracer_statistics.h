// The tracer's counters under their published names.
#pragma once

#include "grtx/frontend/accel/acceleration_structure.h"
#include "grtx/frontend/tracer/tracer.h"
#include "grtx/frontend/tracer/view_tracer.h"
#include "grtx/modules/kernel/statistics.h"

namespace grtx::sim {

/// tracer.*, accel.*, tracer.secondary.* (the share of the secondary rays; all zero without objects) and, when a trace
/// was written, trace.* (deterministic).
modules::StatisticList tracer_statistics(const frontend::ViewTracer& view, const frontend::TracedView& traced);
/// tracer.wall_seconds, tracer.rays_per_second, accel.build_seconds: depend on the host.
modules::StatisticList tracer_host_statistics(const frontend::AccelerationStructure& accel,
                                              const frontend::RenderResult& result);

}  // namespace grtx::sim
