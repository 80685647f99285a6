// SPDX-License-Identifier: Apache-2.0
// The tracer's statistics, and the statistics document of a traced view.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "grtx/experiment/tracer_settings.h"
#include "grtx/frontend/tracer/scene_tracer.h"
#include "grtx/frontend/tracer/tracer.h"
#include "grtx/modules/kernel/declare.h"
#include "grtx/rtl_tlm/run/result_notes.h"

namespace grtx::experiment {

/// Text for the user below a table: how the rays of a view end, and how much lies behind their ends.
std::string describe_end(const frontend::TracerCounters& counters);

/// Writes the image to `path`; for a sequence, one per frame (frame_path).
void write_images(const std::string& path, const frontend::TracedView& traced);

/// tracer.*, accel.* and, if a trace was written, trace.* (deterministic). For one scene, also tracer.secondary.* (part
/// due to secondary rays; zero without optical objects). For several objects, also accel.update.bytes (bytes written
/// when an object moves).
modules::StatisticList tracer_statistics(const frontend::SceneTracer& scene, const frontend::TracedView& traced);
/// tracer.wall_seconds, tracer.rays_per_second, accel.build_seconds: depend on the host. For several objects, also
/// accel.update.seconds.
modules::StatisticList tracer_host_statistics(const frontend::SceneTracer& scene, const frontend::RenderResult& result);

/// Notes on limitations of a trace's results and of simulations with it.
sim::ResultNotes view_notes(const frontend::TracedView& traced, const TracerSettings& settings);
/// All statistics as a grtx.stats/1 document. machine: name as given by the user.
nlohmann::ordered_json view_document(const frontend::SceneTracer& scene, const frontend::TracedView& traced,
                                     const TracerSettings& settings, bool checkpoint, frontend::AccelKind accel,
                                     const std::string& machine);

}  // namespace grtx::experiment
