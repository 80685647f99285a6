// The tracer's counters under their published names.
#pragma once

#include <string>

#include "grtx/frontend/accel/acceleration_structure.h"
#include "grtx/frontend/tracer/tracer.h"
#include "grtx/frontend/tracer/view_tracer.h"
#include "grtx/modules/kernel/declare.h"

namespace grtx::sim {

/// How the rays of a view end, and how much lies behind their ends: for people, below a table.
std::string describe_end(const frontend::TracerCounters& counters);

/// The image to `path`; of a sequence one a frame (frame_path).
void write_images(const std::string& path, const frontend::TracedView& traced);

/// tracer.*, accel.*, tracer.secondary.* (the share of the secondary rays; all zero without objects) and, when a trace
/// was written, trace.* (deterministic).
modules::StatisticList tracer_statistics(const frontend::ViewTracer& view, const frontend::TracedView& traced);
/// The same for several objects: accel.update.bytes is what a move writes; no tracer.secondary.*.
modules::StatisticList tracer_statistics(const frontend::MultiObjectWorld& world, const frontend::TracedView& traced);
/// tracer.wall_seconds, tracer.rays_per_second, accel.build_seconds: depend on the host.
modules::StatisticList tracer_host_statistics(const frontend::AccelerationStructure& accel,
                                              const frontend::RenderResult& result);
/// With accel.update.seconds beside accel.build_seconds.
modules::StatisticList tracer_host_statistics(const frontend::MultiObjectWorld& world,
                                              const frontend::RenderResult& result);

}  // namespace grtx::sim
