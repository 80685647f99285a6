#include "grtx/apps/grtx/tracer_statistics.h"

#include <fmt/format.h>

#include <algorithm>

#include "grtx/apps/grtx/options.h"
#include "grtx/frontend/image/image.h"

namespace grtx::sim {
namespace {

double ratio(std::uint64_t part, std::uint64_t whole) {
  return static_cast<double>(part) / static_cast<double>(std::max<std::uint64_t>(1, whole));
}

void add_tracer_statistics(modules::StatisticList& list, const frontend::RenderResult& result) {
  const frontend::TracerCounters& c = result.counters;
  list.add("tracer.rays", c.rays, "rays", "rays traced, secondary ones included");
  list.add("tracer.rounds", c.rounds, "rounds", "traceRay calls, summed over rays");
  list.add("tracer.visits.internal", c.visits_internal, "visits", "internal nodes processed by a ray");
  list.add("tracer.visits.instance", c.visits_instance, "visits",
           "instance leaves processed, replay transforms included");
  list.add("tracer.visits.leaf", c.visits_leaf, "visits", "primitive leaves processed");
  list.add("tracer.visits.total", c.visits(), "visits", "nodes processed, all kinds");
  list.add("tracer.visits.unique", c.visits_unique, "visits", "distinct nodes a ray, summed over rays");
  list.add("tracer.any_hit.calls", c.any_hit_calls(), "calls", "any-hit shader invocations");
  list.add("tracer.any_hit.inserted", c.any_hit_inserted, "calls", "hits that entered the k-buffer");
  list.add("tracer.any_hit.evicted", c.any_hit_evicted, "hits", "hits that left or did not enter a full k-buffer");
  list.add("tracer.any_hit.rejected", c.any_hit_rejected, "calls", "hits that did not fit and were reported");
  list.add("tracer.any_hit.ignored", c.any_hit_ignored, "calls", "ties at the resume point that were already blended");
  list.add("tracer.checkpoint.written", c.checkpoints_written, "entries", "checkpoint entries written");
  list.add("tracer.checkpoint.read", c.checkpoints_read, "entries", "checkpoint entries read");
  list.add("tracer.checkpoint.max_per_ray", c.checkpoints_max_per_ray, "entries",
           "most entries in one buffer of a ray");
  list.add("tracer.checkpoint.overflows", c.checkpoint_overflows, "rounds", "rounds whose destination buffer ran full");
  list.add("tracer.eviction.max_per_ray", c.evictions_max_per_ray, "entries", "most entries in one eviction buffer");
  list.add("tracer.processed", c.processed, "hits", "k-buffer entries looked at when blending");
  list.add("tracer.blended", c.blended, "hits", "hits blended into a pixel");
  list.add("tracer.terminated", c.terminated, "rays", "rays ended by early ray termination");
  const RaysEnd end = rays_end(result);
  list.add("tracer.ert_share", end.ert_share(), "ratio", "rays ended by early ray termination / rays");
  if (end.hits) {
    list.add("tracer.hits", *end.hits, "hits", "proxy hits of all rays, those behind early ray termination included");
    list.add("tracer.hits_behind_end", end.hits_behind_end(), "ratio",
             "tracer.hits / tracer.processed: hits that rays have for each that they process");
  }
  list.add("tracer.ties_lost", c.ties_lost, "hits", "ties at the resume point lost by --resume strict");
  list.add("tracer.inside_skipped", c.inside_skipped, "hits", "Gaussians skipped because their proxy holds the origin");
  list.add("tracer.single.overflows", c.single_overflows, "rounds", "single-round: a hit met a full buffer of k hits");
  list.add("tracer.nearest_commits", c.nearest_commits, "hits", "closest-hit: hits that became the nearest so far");
  list.add("tracer.doubled", c.doubled, "hits", "--triangle-test world: Gaussians processed by a ray once more");
  list.add("tracer.skipped.retests", c.skipped_retests, "tests", "left out: nodes that the ray had tested before");
  list.add("tracer.skipped.dead_colours", c.skipped_dead_colours, "colours",
           "left out: of hits behind the one that ended a ray");
  list.add("tracer.skipped.sh_bands", c.skipped_sh_bands, "coefficients", "left out: above the scene's degree");
  list.add("tracer.skipped.scene_misses", c.skipped_scene_misses, "rays",
           "left out: rays that miss all boxes of the root");
  list.add("tracer.skipped.events", c.skipped_events, "visits", "left out: visits that no trace asked for");
  list.add("tracer.skipped.never_accepted", c.skipped_never_accepted, "tests",
           "left out: of Gaussians whose alpha stays below 1/255");
  list.add("tracer.skipped.blas_walks", c.skipped_blas_walks, "walks",
           "left out: instances decided without a walk of the BLAS");
}

void add_accel_statistics(modules::StatisticList& list, const frontend::ViewTracer& view,
                          const frontend::RenderResult& result) {
  const frontend::AccelerationStructure& accel = view.accel();
  const double gaussians = static_cast<double>(std::max<std::size_t>(1, view.scene().size()));
  const auto& nodes = accel.counts();
  list.add("accel.bytes", accel.image().size(), "B", "size of the node image, headers and BLAS included");
  list.add("accel.bytes_per_gaussian", static_cast<double>(accel.image().size()) / gaussians, "B",
           "accel.bytes / Gaussians");
  list.add("accel.height", std::uint64_t{accel.height()}, "levels",
           "levels of the BVH or TLAS, root and leaves included");
  list.add("accel.blas_height", std::uint64_t{accel.blas_height()}, "levels", "levels of the shared BLAS; 0: none");
  list.add("accel.nodes.internal", nodes.internal, "nodes", "internal nodes of the BVH or TLAS");
  list.add("accel.nodes.instance", nodes.instance, "nodes", "instance leaves");
  list.add("accel.nodes.triangle", nodes.triangle, "nodes", "triangle leaves of a monolithic BVH");
  list.add("accel.nodes.procedural", nodes.procedural, "nodes", "procedural leaves of a monolithic BVH");
  list.add("accel.nodes.blas", nodes.blas_nodes, "nodes", "nodes of the shared BLAS");
  if (accel.image().sizes().oriented()) {
    list.add("accel.nodes.oriented", nodes.oriented, "nodes", "internal nodes whose boxes are rotated");
  }
  list.add("accel.footprint_bytes", result.footprint_bytes, "B", "distinct node bytes touched by the view");
}

void add_object_statistics(modules::StatisticList& list, const frontend::MultiObjectWorld& world,
                           const frontend::RenderResult& result) {
  list.add("accel.bytes", world.image().size(), "B", "node image: scene TLAS, TLAS of each file, shared BLAS");
  list.add("accel.bytes_per_gaussian", ratio(world.image().size(), world.gaussians()), "B",
           "accel.bytes / Gaussians of all placements");
  list.add("accel.scene_tlas_bytes", world.scene_tlas_bytes(), "B", "set aside for the scene TLAS");
  list.add("accel.update.bytes", world.update_bytes(), "B",
           "written when objects move: the scene TLAS as it was built last");
  list.add("accel.objects", std::uint64_t{world.placed().size()}, "objects", "placements");
  list.add("accel.files", std::uint64_t{world.objects().size()}, "files", "TLASes of objects");
  list.add("accel.gaussians", world.gaussians(), "Gaussians", "of all placements");
  list.add("accel.footprint_bytes", result.footprint_bytes, "B", "distinct node bytes touched by the view");
}

void add_secondary_statistics(modules::StatisticList& list, const frontend::SecondaryPlan& plan,
                              const frontend::RenderResult& result) {
  const frontend::TracerCounters& c = result.secondary;
  std::uint64_t glass = 0;
  for (const frontend::SecondaryGroup& group : plan.groups) {
    if (group.kind == traces::RayKind::glass) glass += group.count;
  }
  list.add("tracer.secondary.rays", c.rays, "rays", "secondary rays traced");
  list.add("tracer.secondary.glass_rays", glass, "rays", "of those, rays that come from the glass sphere's surface");
  list.add("tracer.secondary.mirror_rays", plan.rays.size() - glass, "rays",
           "of those, rays that come from the mirror");
  list.add("tracer.secondary.groups", std::uint64_t{plan.groups.size()}, "groups", "warps of secondary rays");
  list.add("tracer.secondary.truncated", plan.truncated, "paths", "paths cut off by --secondary-bounces");
  list.add("tracer.secondary.rounds", c.rounds, "rounds", "traceRay calls of secondary rays");
  list.add("tracer.secondary.visits.internal", c.visits_internal, "visits", "internal nodes processed by them");
  list.add("tracer.secondary.visits.instance", c.visits_instance, "visits", "instance leaves processed by them");
  list.add("tracer.secondary.visits.leaf", c.visits_leaf, "visits", "primitive leaves processed by them");
  list.add("tracer.secondary.visits.total", c.visits(), "visits", "nodes processed by them");
  list.add("tracer.secondary.visits.unique", c.visits_unique, "visits", "distinct nodes a secondary ray, summed");
  list.add("tracer.secondary.any_hit.calls", c.any_hit_calls(), "calls", "any-hit shader invocations of theirs");
  list.add("tracer.secondary.checkpoint.written", c.checkpoints_written, "entries", "checkpoint entries they wrote");
  list.add("tracer.secondary.checkpoint.read", c.checkpoints_read, "entries", "checkpoint entries they read");
  list.add("tracer.secondary.blended", c.blended, "hits", "hits they blended");
  list.add("tracer.secondary.terminated", c.terminated, "rays", "of them ended by early ray termination");
  list.add("tracer.secondary.inside_skipped", c.inside_skipped, "hits",
           "Gaussians they skipped because the proxy holds their origin");
}

void add_trace_statistics(modules::StatisticList& list, const frontend::TraceFile& trace) {
  list.add("trace.bytes", trace.bytes, "B", "size of the trace file");
  list.add("trace.bytes_per_visit", ratio(trace.bytes, trace.visits), "B", "trace.bytes / node visits");
}

modules::StatisticList host_statistics(const frontend::RenderResult& result) {
  modules::StatisticList list;
  const double seconds = std::max(result.seconds, 1e-9);
  list.add("tracer.wall_seconds", result.seconds, "s", "host time of tracing alone");
  list.add("tracer.rays_per_second", static_cast<double>(result.counters.rays) / seconds, "1/s", "rays / wall_seconds");
  list.add("tracer.visits_per_second", static_cast<double>(result.counters.visits()) / seconds, "1/s",
           "node visits / wall_seconds");
  return list;
}

}  // namespace

void write_images(const std::string& path, const frontend::TracedView& traced) {
  const bool sequence = !traced.further.empty();
  frontend::write_image(sequence ? frame_path(path, 0) : path, traced.result.image);
  for (std::size_t i = 0; i < traced.further.size(); ++i) {
    frontend::write_image(frame_path(path, i + 1), traced.further[i]);
  }
}

double RaysEnd::ert_share() const { return ratio(terminated, rays); }
double RaysEnd::hits_behind_end() const { return ratio(hits.value_or(0), processed); }

RaysEnd rays_end(const frontend::RenderResult& result) {
  const frontend::TracerCounters& c = result.counters;
  return {c.rays, c.terminated, c.processed, result.hits};
}

std::string describe(const RaysEnd& end) {
  std::string text = fmt::format("{:.1f} % of rays end by early termination", 100.0 * end.ert_share());
  if (end.hits) text += fmt::format("; there are {:.2f} hits for each that is processed", end.hits_behind_end());
  return text;
}

modules::StatisticList tracer_statistics(const frontend::ViewTracer& view, const frontend::TracedView& traced) {
  modules::StatisticList list;
  add_tracer_statistics(list, traced.result);
  add_accel_statistics(list, view, traced.result);
  add_secondary_statistics(list, traced.plan, traced.result);
  if (traced.trace) add_trace_statistics(list, *traced.trace);
  return list;
}

modules::StatisticList tracer_statistics(const frontend::MultiObjectWorld& world, const frontend::TracedView& traced) {
  modules::StatisticList list;
  add_tracer_statistics(list, traced.result);
  add_object_statistics(list, world, traced.result);
  if (traced.trace) add_trace_statistics(list, *traced.trace);
  return list;
}

modules::StatisticList tracer_host_statistics(const frontend::AccelerationStructure& accel,
                                              const frontend::RenderResult& result) {
  modules::StatisticList list = host_statistics(result);
  list.add("accel.build_seconds", accel.build_seconds(), "s", "host time of rtcBuildBVH");
  list.add("accel.pack_seconds", accel.pack_seconds(), "s", "host time of encoding the node image");
  return list;
}

modules::StatisticList tracer_host_statistics(const frontend::MultiObjectWorld& world,
                                              const frontend::RenderResult& result) {
  modules::StatisticList list = host_statistics(result);
  list.add("accel.build_seconds", world.build_seconds(), "s", "host time of building all structures");
  list.add("accel.update.seconds", world.update_seconds(), "s",
           "host time of building the scene TLAS alone, as when objects move");
  return list;
}

}  // namespace grtx::sim
