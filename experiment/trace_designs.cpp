// SPDX-License-Identifier: Apache-2.0
#include "grtx/experiment/trace_designs.h"

#include <utility>

#include "grtx/experiment/scene_trace.h"
#include "grtx/experiment/tracer_statistics.h"
#include "grtx/rtl_tlm/run/statistics_json.h"

namespace grtx::experiment {
namespace {

using Images = std::vector<frontend::Image>;

bool same(const Images& a, const Images& b) {
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (!frontend::compare(a[i], b[i]).identical()) return false;
  }
  return true;
}

/// The order in which a design's hits are blended. Peaks are the same for all proxies, entries are not. Gaussians that
/// are rounded to their codes have an order of their own.
std::string order_of(const TracerSettings& settings, frontend::AccelKind kind) {
  const std::string suffix = frontend::is_quantised(settings.layout) ? " of quantised Gaussians" : "";
  if (settings.options.sort_key == frontend::SortKey::peak) return "peak" + suffix;
  return (frontend::proxy_of(kind) == frontend::ProxyKind::sphere ? "entry into spheres" : "entry into polyhedra") +
         suffix;
}

/// Compares the images of designs: those that blend in one order must be the same.
class ImageComparison {
 public:
  void take(TracedDesigns& all, const std::string& name, const std::string& order, frontend::TracedView& traced) {
    Images images = std::move(traced.further);
    images.insert(images.begin(), std::move(traced.result.image));
    if (first_.empty()) first_ = order;
    if (order != first_) all.other_orders[name] = {order, frontend::compare(by_order_[first_][0], images[0]).psnr};
    const auto [known, is_new] = by_order_.try_emplace(order, std::move(images));
    if (!is_new) all.identical = all.identical && same(known->second, images);
  }
  Images first() { return std::move(by_order_[first_]); }
  const Images& at(const std::string& order) const { return by_order_.at(order); }

 private:
  std::string first_;  ///< order of the first design
  std::map<std::string, Images> by_order_;
};

/// The pictures of a design without what rounds Gaussians and responses.
Images at_full_precision(frontend::SceneTracer& scene, TracerSettings settings, const ComparedDesign& design,
                         const FilesRead& files, bool quiet) {
  settings.layout = TracerSettings().layout;
  settings.options.response_precision = frontend::ResponsePrecision::fp32;
  frontend::TracedView traced =
      trace_scene(scene, settings, design.checkpoint, design.kind, render_options(settings, quiet), "", files);
  Images images = std::move(traced.further);
  images.insert(images.begin(), std::move(traced.result.image));
  return images;
}

bool is_rounded(const TracerSettings& settings) {
  return frontend::is_quantised(settings.layout) ||
         settings.options.response_precision != frontend::ResponsePrecision::fp32;
}

/// Compares frames with those of the reference on its pixels, all if it has none.
void compare_with(const Images& images, const Images& reference, const std::vector<std::size_t>& pixels,
                  PictureQuality& quality) {
  quality.pixels = pixels.empty() ? reference.front().pixels.size() : pixels.size();
  for (std::size_t i = 0; i < images.size(); ++i) {
    quality.reference.push_back(psnr_on(images[i], reference[i], pixels));
  }
}

}  // namespace

TracerSettings design_settings(TracerSettings settings, const explore::Design& design,
                               const std::set<std::string>& named) {
  for (const auto& [option, value] : design.tracer) {
    if (!named.contains(option)) set_option(settings, option, value);
  }
  return settings;
}

TracedDesigns trace_designs(const DesignTracing& tracing, const DesignComparison& comparison) {
  FilesRead files;
  const std::vector<frontend::Camera> cameras = select_cameras(tracing.view, files);
  frontend::SceneTracer scene;
  // With several objects, all designs share one structure; it is built when the objects are loaded.
  load_scene(scene, tracing.scene, tracing.several_objects, cameras, tracing.tracer, comparison.designs().front().kind,
             files, tracing.quiet);
  if (tracing.opened) tracing.opened(files);
  TracedDesigns all;
  all.files_hash = files.hash();
  ImageComparison images;
  // Before a structure is built, which may round the scene.
  ReferencePictures references(scene.view() == nullptr ? nullptr : &scene.view()->scene(), cameras, tracing.quiet);
  for (const ComparedDesign& design : comparison.designs()) {
    references.frames(design_settings(tracing.tracer, design, tracing.named), design.kind);
  }
  for (const ComparedDesign& design : comparison.designs()) {
    const TracerSettings settings = design_settings(tracing.tracer, design, tracing.named);
    frontend::RenderOptions render = render_options(settings, tracing.quiet);
    render.count_unique = true;
    render.count_hits = !all.counters.hits;  // counted once: hits are the same in each design
    TracedDesign& result = all.designs[design.name];
    result.path = tracing.folder + "/" + design.name + ".grtx";
    PictureQuality& quality = all.pictures[design.name];
    const ReferencePictures::Frames& reference = references.frames(settings, design.kind);
    quality.fp64 = !reference.images.empty();
    // First, in the structure of the design before it, which may be the same: each is built once.
    Images precise;
    if (!quality.fp64 && is_rounded(settings)) {
      precise = at_full_precision(scene, settings, design, files, tracing.quiet);
    }
    frontend::TracedView traced =
        trace_scene(scene, settings, design.checkpoint, design.kind, render, result.path, files);
    result.file = traced.trace.value();
    frontend::RenderResult& rendered = traced.result;
    if (!rendered.counters.hits) rendered.counters.hits = all.counters.hits;
    all.counters = rendered.counters;
    result.statistics = sim::statistics_object(tracer_statistics(scene, traced));
    result.statistics.update(sim::statistics_object(tracer_host_statistics(scene, rendered)));
    quality.order = order_of(settings, design.kind);
    images.take(all, design.name, quality.order, traced);
    const Images& own = images.at(quality.order);
    if (quality.fp64) {
      compare_with(own, reference.images, reference.pixels, quality);
    } else {
      compare_with(own, precise.empty() ? own : precise, {}, quality);
    }
  }
  const Images& over = images.at(all.pictures.at(comparison.reference()).order);
  for (auto& [name, quality] : all.pictures) {
    const Images& own = images.at(quality.order);
    for (std::size_t i = 0; i < own.size(); ++i) quality.over.push_back(psnr_on(own[i], over[i], {}));
  }
  all.images = images.first();
  return all;
}

}  // namespace grtx::experiment
