#include "grtx/study/trace_designs.h"

#include <utility>

#include "grtx/rtl_tlm/run/statistics_json.h"
#include "grtx/study/scene_trace.h"
#include "grtx/study/tracer_statistics.h"

namespace grtx::sim {
namespace {

/// Keeps the images of the first design and compares those of the others with them.
void take_images(TracedDesigns& all, frontend::TracedView& traced) {
  std::vector<frontend::Image> images = std::move(traced.further);
  images.insert(images.begin(), std::move(traced.result.image));
  if (all.images.empty()) {
    all.images = std::move(images);
    return;
  }
  for (std::size_t i = 0; i < images.size(); ++i) {
    all.identical = all.identical && frontend::compare(all.images[i], images[i]).identical();
  }
}

}  // namespace

TracedDesigns trace_designs(const DesignTracing& tracing, const DesignComparison& comparison) {
  FilesRead files;
  const std::vector<frontend::Camera> cameras = select_cameras(tracing.view, files);
  frontend::SceneTracer scene;
  // With several objects, all designs share one structure; it is built when the objects are loaded.
  load_scene(scene, tracing.scene, tracing.several_objects, cameras, tracing.tracer, comparison.designs().front().accel,
             files, tracing.quiet);
  if (tracing.opened) tracing.opened(files);
  TracedDesigns all;
  all.files_hash = files.hash();
  for (const Design& design : comparison.designs()) {
    frontend::RenderOptions render = render_options(tracing.tracer, tracing.quiet);
    render.count_unique = true;
    render.count_hits = !all.counters.hits;  // counted once: hits are the same in each design
    TracedDesign& result = all.designs[design.name];
    result.path = tracing.folder + "/" + design.name + ".grtx";
    frontend::TracedView traced =
        trace_scene(scene, tracing.tracer, design.checkpoint, design.accel, render, result.path, files);
    result.file = traced.trace.value();
    frontend::RenderResult& rendered = traced.result;
    if (!rendered.counters.hits) rendered.counters.hits = all.counters.hits;
    all.counters = rendered.counters;
    result.statistics = statistics_object(tracer_statistics(scene, traced));
    result.statistics.update(statistics_object(tracer_host_statistics(scene, rendered)));
    take_images(all, traced);
  }
  return all;
}

}  // namespace grtx::sim
