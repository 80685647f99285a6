// The tracer's counters under their published names, and the document of a traced view.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "grtx/frontend/tracer/scene_tracer.h"
#include "grtx/frontend/tracer/tracer.h"
#include "grtx/modules/kernel/declare.h"
#include "grtx/rtl_tlm/run/result_notes.h"
#include "grtx/study/tracer_settings.h"

namespace grtx::sim {

/// How the rays of a view end, and how much lies behind their ends: for people, below a table.
std::string describe_end(const frontend::TracerCounters& counters);

/// The image to `path`; of a sequence one a frame (frame_path).
void write_images(const std::string& path, const frontend::TracedView& traced);

/// tracer.*, accel.* and, when a trace was written, trace.* (deterministic). Of one scene, tracer.secondary.* (the
/// share of the secondary rays; all zero without objects); of several objects, accel.update.bytes, what a move writes.
modules::StatisticList tracer_statistics(const frontend::SceneTracer& scene, const frontend::TracedView& traced);
/// tracer.wall_seconds, tracer.rays_per_second, accel.build_seconds: depend on the host. Of several objects with
/// accel.update.seconds.
modules::StatisticList tracer_host_statistics(const frontend::SceneTracer& scene, const frontend::RenderResult& result);

/// What limits the meaning of a trace's figures, and of what is simulated with it.
ResultNotes view_notes(const frontend::TracedView& traced, const TracerSettings& settings);
/// All of it as grtx.stats/1. machine: as somebody names it.
nlohmann::ordered_json view_document(const frontend::SceneTracer& scene, const frontend::TracedView& traced,
                                     const TracerSettings& settings, bool checkpoint, frontend::AccelKind accel,
                                     const std::string& machine);

}  // namespace grtx::sim
