// SPDX-License-Identifier: Apache-2.0
#include "grtx/experiment/tracer_statistics.h"

#include <fmt/format.h>

#include <algorithm>

#include "grtx/experiment/machine.h"
#include "grtx/experiment/view_choice.h"
#include "grtx/frontend/image/image.h"
#include "grtx/rtl_tlm/run/statistics_json.h"

namespace grtx::experiment {
namespace {

using declare::StatisticKind;

double ratio(std::uint64_t part, std::uint64_t whole) {
  return static_cast<double>(part) / static_cast<double>(std::max<std::uint64_t>(1, whole));
}

void add_accel_statistics(modules::StatisticList& list, const frontend::ViewTracer& view,
                          const frontend::RenderResult& result) {
  const frontend::AccelerationStructure& accel = view.accel();
  const double gaussians = static_cast<double>(std::max<std::size_t>(1, view.scene().size()));
  const auto& nodes = accel.counts();
  list.add("accel.bytes", accel.image().size(), "B", "size of the node image, headers and BLAS included",
           StatisticKind::count);
  list.add("accel.bytes_per_gaussian", static_cast<double>(accel.image().size()) / gaussians, "B",
           "accel.bytes / Gaussians", StatisticKind::ratio);
  list.add("accel.height", std::uint64_t{accel.height()}, "levels",
           "levels of the BVH or TLAS, root and leaves included", StatisticKind::state);
  list.add("accel.blas_height", std::uint64_t{accel.blas_height()}, "levels", "levels of the shared BLAS; 0: none",
           StatisticKind::state);
  list.add("accel.nodes.internal", nodes.internal, "nodes", "internal nodes of the BVH or TLAS", StatisticKind::count);
  list.add("accel.nodes.instance", nodes.instance, "nodes", "instance leaves", StatisticKind::count);
  list.add("accel.nodes.triangle", nodes.triangle, "nodes", "triangle leaves of a monolithic BVH",
           StatisticKind::count);
  list.add("accel.nodes.procedural", nodes.procedural, "nodes", "procedural leaves of a monolithic BVH",
           StatisticKind::count);
  list.add("accel.nodes.wide", nodes.wide, "nodes",
           "of instance and procedural leaves, those of 64 B in layout quantised: no code of 32 B holds their Gaussian",
           StatisticKind::count);
  list.add("accel.nodes.blas", nodes.blas_nodes, "nodes", "nodes of the shared BLAS", StatisticKind::count);
  list.add("accel.clamped_sh", view.clamped_sh(), "channels",
           "of spherical harmonics, set to 65,504, the most that the fp16 of layout quantised holds",
           StatisticKind::count);
  list.add("accel.footprint_bytes", result.footprint_bytes, "B", "distinct node bytes touched by the view",
           StatisticKind::count);
}

void add_object_statistics(modules::StatisticList& list, const frontend::MultiObjectWorld& world,
                           const frontend::RenderResult& result) {
  list.add("accel.bytes", world.image().size(), "B", "node image: scene TLAS, TLAS of each file, shared BLAS",
           StatisticKind::count);
  list.add("accel.bytes_per_gaussian", ratio(world.image().size(), world.gaussians()), "B",
           "accel.bytes / Gaussians of all placements", StatisticKind::ratio);
  list.add("accel.scene_tlas_bytes", world.scene_tlas_bytes(), "B", "set aside for the scene TLAS",
           StatisticKind::count);
  list.add("accel.update.bytes", world.update_bytes(), "B",
           "written when objects move: the scene TLAS as it was built last", StatisticKind::count);
  list.add("accel.objects", std::uint64_t{world.placed().size()}, "objects", "placements", StatisticKind::count);
  list.add("accel.files", std::uint64_t{world.objects().size()}, "files", "TLASes of objects", StatisticKind::count);
  list.add("accel.gaussians", world.gaussians(), "Gaussians", "of all placements", StatisticKind::count);
  list.add("accel.footprint_bytes", result.footprint_bytes, "B", "distinct node bytes touched by the view",
           StatisticKind::count);
}

void add_secondary_statistics(modules::StatisticList& list, const frontend::SecondaryPlan& plan,
                              const frontend::RenderResult& result) {
  const frontend::TracerCounters& c = result.secondary;
  std::uint64_t glass = 0;
  for (const frontend::SecondaryGroup& group : plan.groups) {
    if (group.kind == traces::RayKind::glass) glass += group.count;
  }
  list.add("tracer.secondary.rays", c.rays, "rays", "secondary rays traced", StatisticKind::count);
  list.add("tracer.secondary.glass_rays", glass, "rays", "of those, rays that come from the glass sphere's surface",
           StatisticKind::count);
  list.add("tracer.secondary.mirror_rays", plan.rays.size() - glass, "rays", "of those, rays that come from the mirror",
           StatisticKind::count);
  list.add("tracer.secondary.groups", std::uint64_t{plan.groups.size()}, "groups", "warps of secondary rays",
           StatisticKind::count);
  list.add("tracer.secondary.truncated", plan.truncated, "paths", "paths cut off by --secondary-bounces",
           StatisticKind::count);
  list.add("tracer.secondary.rounds", c.rounds, "rounds", "traceRay calls of secondary rays", StatisticKind::count);
  list.add("tracer.secondary.visits.internal", c.visits_internal, "visits", "internal nodes processed by them",
           StatisticKind::count);
  list.add("tracer.secondary.visits.instance", c.visits_instance, "visits", "instance leaves processed by them",
           StatisticKind::count);
  list.add("tracer.secondary.visits.leaf", c.visits_leaf, "visits", "primitive leaves processed by them",
           StatisticKind::count);
  list.add("tracer.secondary.visits.total", c.visits(), "visits", "nodes processed by them", StatisticKind::count);
  list.add("tracer.secondary.visits.unique", c.visits_unique, "visits", "distinct nodes a secondary ray, summed",
           StatisticKind::count);
  list.add("tracer.secondary.any_hit.calls", c.any_hit_calls(), "calls", "any-hit shader invocations of theirs",
           StatisticKind::count);
  list.add("tracer.secondary.checkpoint.written", c.checkpoints_written, "entries", "checkpoint entries they wrote",
           StatisticKind::count);
  list.add("tracer.secondary.checkpoint.read", c.checkpoints_read, "entries", "checkpoint entries they read",
           StatisticKind::count);
  list.add("tracer.secondary.blended", c.blended, "hits", "hits they blended", StatisticKind::count);
  list.add("tracer.secondary.terminated", c.terminated, "rays", "of them ended by early ray termination",
           StatisticKind::count);
  list.add("tracer.secondary.inside_skipped", c.inside_skipped, "hits",
           "Gaussians they skipped because the proxy holds their origin", StatisticKind::count);
}

}  // namespace

void write_images(const std::string& path, const frontend::TracedView& traced) {
  const bool sequence = !traced.further.empty();
  frontend::write_image(sequence ? frame_path(path, 0) : path, traced.result.image);
  for (std::size_t i = 0; i < traced.further.size(); ++i) {
    frontend::write_image(frame_path(path, i + 1), traced.further[i]);
  }
}

std::string describe_end(const frontend::TracerCounters& c) {
  std::string text = fmt::format("{:.1f} % of rays end by early termination", 100.0 * c.ert_share());
  if (c.hits && c.processed > 0)
    text += fmt::format("; there are {:.2f} hits for each that is processed", c.hits_behind_end());
  return text;
}

modules::StatisticList tracer_statistics(const frontend::SceneTracer& scene, const frontend::TracedView& traced) {
  modules::StatisticList list;
  frontend::TracerCounters::table().describe(traced.result.counters, list, "tracer");
  if (scene.view() != nullptr) {
    add_accel_statistics(list, *scene.view(), traced.result);
    add_secondary_statistics(list, traced.plan, traced.result);
  } else {
    add_object_statistics(list, *scene.world(), traced.result);
  }
  if (traced.trace) {
    list.add("trace.bytes", traced.trace->bytes, "B", "size of the trace file", StatisticKind::count);
    list.add("trace.bytes_per_visit", ratio(traced.trace->bytes, traced.trace->visits), "B",
             "trace.bytes / node visits", StatisticKind::ratio);
  }
  return list;
}

modules::StatisticList tracer_host_statistics(const frontend::SceneTracer& scene,
                                              const frontend::RenderResult& result) {
  modules::StatisticList list;
  const double seconds = std::max(result.seconds, 1e-9);
  list.add("tracer.wall_seconds", result.seconds, "s", "host time of tracing alone", StatisticKind::count);
  list.add("tracer.rays_per_second", static_cast<double>(result.counters.rays) / seconds, "1/s", "rays / wall_seconds",
           StatisticKind::ratio);
  list.add("tracer.visits_per_second", static_cast<double>(result.counters.visits()) / seconds, "1/s",
           "node visits / wall_seconds", StatisticKind::ratio);
  if (scene.view() != nullptr) {
    const frontend::AccelerationStructure& accel = scene.view()->accel();
    list.add("accel.build_seconds", accel.build_seconds(), "s", "host time of rtcBuildBVH", StatisticKind::count);
    list.add("accel.pack_seconds", accel.pack_seconds(), "s", "host time of encoding the node image",
             StatisticKind::count);
  } else {
    list.add("accel.build_seconds", scene.world()->build_seconds(), "s", "host time of building all structures",
             StatisticKind::count);
    list.add("accel.update.seconds", scene.world()->update_seconds(), "s",
             "host time of building the scene TLAS alone, as when objects move", StatisticKind::count);
  }
  return list;
}

sim::ResultNotes view_notes(const frontend::TracedView& traced, const TracerSettings& settings) {
  traces::Header header;
  header.inputs = traced.inputs;
  header.checkpoint_capacity = settings.options.checkpoint_capacity;
  traces::Totals totals;
  for (const frontend::TracerCounters* counted : {&traced.result.counters, &traced.result.secondary}) {
    totals.rounds += counted->rounds;
    totals.any_hit_calls += counted->any_hit_calls();
    totals.overflows += counted->checkpoint_overflows;
  }
  return sim::trace_notes(header, totals);
}

nlohmann::ordered_json view_document(const frontend::SceneTracer& scene, const frontend::TracedView& traced,
                                     const TracerSettings& settings, bool checkpoint, frontend::AccelKind accel,
                                     const std::string& machine) {
  nlohmann::ordered_json config;
  for (const auto& [name, value] : option_inputs(settings, checkpoint, accel)) config[name] = value;
  nlohmann::ordered_json document =
      sim::statistics_document(config, traced.inputs, view_notes(traced, settings), tracer_statistics(scene, traced),
                               tracer_host_statistics(scene, traced.result));
  document["inputs"]["machine"] = machine_name(machine);
  return document;
}

}  // namespace grtx::experiment
