// SPDX-License-Identifier: Apache-2.0
#include "grtx/experiment/trace_designs.h"

#include <algorithm>
#include <map>
#include <optional>
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

/// A trace to make, for all designs and machines that ask for the same: of a design, with options.
struct AskedTrace {
  const ComparedDesign* design = nullptr;
  TracerSettings settings;
  std::map<std::string, std::string> inputs;  ///< what makes it
  frontend::AccelOptions structure;
  std::string path;

  TracedDesign made;
  frontend::TracerCounters counters;
  PictureQuality quality;
};

AskedTrace asked_trace(const DesignTracing& tracing, const MachineTracing& machine, const ComparedDesign& design) {
  AskedTrace asked;
  asked.design = &design;
  asked.settings = design_settings(machine.tracer, design, tracing.named);
  asked.inputs = option_inputs(asked.settings, design.checkpoint, design.kind);
  if (!design.checkpoint) {  // then they make nothing
    for (const char* idle : {"checkpoint_capacity", "checkpoint_order", "replay_tmax"}) asked.inputs.erase(idle);
  }
  asked.structure = accel_options(asked.settings, design.kind);
  asked.path = trace_path(tracing.folder, design.name, &machine == tracing.machines.data() ? "" : machine.name);
  return asked;
}

/// The traces of all designs and machines: those in one structure behind each other, so that each is built once.
class AskedTraces {
 public:
  AskedTraces(const DesignTracing& tracing, const DesignComparison& comparison) {
    std::vector<frontend::AccelOptions> structures;  // in order of appearance
    for (const ComparedDesign& design : comparison.designs()) {
      for (const MachineTracing& machine : tracing.machines) {
        AskedTrace asked = asked_trace(tracing, machine, design);
        if (std::ranges::find(structures, asked.structure) == structures.end()) structures.push_back(asked.structure);
        if (find(asked) == traces.end()) traces.push_back(std::move(asked));
      }
    }
    std::ranges::stable_sort(traces, {},
                             [&](const AskedTrace& asked) { return std::ranges::find(structures, asked.structure); });
    for (const MachineTracing& machine : tracing.machines) {
      std::map<std::string, std::size_t>& own = of_machines.emplace_back();
      for (const ComparedDesign& design : comparison.designs()) {
        own[design.name] = static_cast<std::size_t>(find(asked_trace(tracing, machine, design)) - traces.begin());
      }
    }
  }

  std::vector<AskedTrace> traces;
  std::vector<std::map<std::string, std::size_t>> of_machines;  ///< by machine: design -> index in traces

 private:
  std::vector<AskedTrace>::iterator find(const AskedTrace& asked) {
    return std::ranges::find_if(
        traces, [&](const AskedTrace& known) { return known.design == asked.design && known.inputs == asked.inputs; });
  }
};

/// Compares images: those that are blended in one order must be the same.
class ImageComparison {
 public:
  void take(const std::string& order, frontend::TracedView& traced) {
    Images images = std::move(traced.further);
    images.insert(images.begin(), std::move(traced.result.image));
    const auto [known, is_new] = by_order_.try_emplace(order, std::move(images));
    if (!is_new) identical_ = identical_ && same(known->second, images);
  }
  bool identical() const { return identical_; }
  const Images& at(const std::string& order) const { return by_order_.at(order); }

 private:
  std::map<std::string, Images> by_order_;
  bool identical_ = true;
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

/// The traces by machine and design; compares their pictures with those of the design that speed-ups are over.
std::vector<TracedDesigns> of_machines(const AskedTraces& asked, const ImageComparison& images,
                                       const DesignComparison& comparison) {
  std::vector<TracedDesigns> all;
  for (const std::map<std::string, std::size_t>& of : asked.of_machines) {
    TracedDesigns& on = all.emplace_back();
    const AskedTrace& reference = asked.traces[of.at(comparison.reference())];
    const Images& over = images.at(reference.quality.order);
    for (const auto& [name, index] : of) {
      const AskedTrace& trace = asked.traces[index];
      on.designs[name] = trace.made;
      PictureQuality& quality = on.pictures[name] = trace.quality;
      const Images& own = images.at(quality.order);
      for (std::size_t i = 0; i < own.size(); ++i) quality.over.push_back(psnr_on(own[i], over[i], {}));
      if (quality.order != reference.quality.order) {
        on.other_orders[name] = {quality.order, *std::ranges::min_element(quality.over)};
      }
    }
    on.images = over;
    on.counters = reference.counters;
    on.identical = images.identical();
  }
  return all;
}

}  // namespace

TracerSettings design_settings(TracerSettings settings, const explore::Design& design,
                               const std::set<std::string>& named) {
  for (const auto& [option, value] : design.tracer) {
    if (!named.contains(option)) set_option(settings, option, value);
  }
  return settings;
}

std::string order_of(const TracerSettings& settings, frontend::AccelKind kind) {
  const std::string suffix = frontend::is_quantised(settings.layout) ? " of quantised Gaussians" : "";
  if (settings.options.sort_key == frontend::SortKey::peak) return "peak" + suffix;
  return (frontend::proxy_of(kind) == frontend::ProxyKind::sphere ? "entry into spheres" : "entry into polyhedra") +
         suffix;
}

std::string trace_path(const std::string& folder, const std::string& design, const std::string& machine) {
  return folder + "/" + design + (machine.empty() ? "" : "." + machine) + ".grtx";
}

std::vector<TracedDesigns> trace_designs(const DesignTracing& tracing, const DesignComparison& comparison) {
  FilesRead files;
  const std::vector<frontend::Camera> cameras = select_cameras(tracing.view, files);
  frontend::SceneTracer scene;
  AskedTraces asked(tracing, comparison);
  // With several objects, all designs share one structure; it is built when the objects are loaded.
  const auto load = [&](const AskedTrace& trace, FilesRead& opened) {
    load_scene(scene, tracing.scene, tracing.several_objects, cameras, trace.settings, trace.design->kind, opened,
               tracing.quiet);
  };
  load(asked.traces.front(), files);
  if (tracing.opened) tracing.opened(files);
  ImageComparison images;
  // Before a structure is built, which may round the scene.
  ReferencePictures references(scene.view() == nullptr ? nullptr : &scene.view()->scene(), cameras, tracing.quiet);
  for (const AskedTrace& trace : asked.traces) references.frames(trace.settings, trace.design->kind);
  // All designs of one proxy and order have the same hits: they are counted once.
  std::map<std::pair<frontend::ProxyKind, std::string>, std::optional<std::uint64_t>> hits;
  for (AskedTrace& trace : asked.traces) {
    if (tracing.several_objects && &trace != asked.traces.data()) {  // the same structure stays
      FilesRead again;
      load(trace, again);
    }
    const TracerSettings& settings = trace.settings;
    const ComparedDesign& design = *trace.design;
    frontend::RenderOptions render = render_options(settings, tracing.quiet);
    render.count_unique = true;
    TracedDesign& result = trace.made;
    result.path = trace.path;
    PictureQuality& quality = trace.quality;
    quality.order = order_of(settings, design.kind);
    std::optional<std::uint64_t>& own_hits = hits[{frontend::proxy_of(design.kind), quality.order}];
    render.count_hits = !own_hits;
    const ReferencePictures::Frames& reference = references.frames(settings, design.kind);
    quality.fp64 = !reference.images.empty();
    // First, in the structure of the design before it, which may be the same: each is built once.
    const bool rounded = !quality.fp64 && is_rounded(settings);
    const Images precise = rounded ? at_full_precision(scene, settings, design, files, tracing.quiet) : Images();
    frontend::TracedView traced =
        trace_scene(scene, settings, design.checkpoint, design.kind, render, result.path, files);
    result.file = traced.trace.value();
    frontend::RenderResult& rendered = traced.result;
    if (render.count_hits) own_hits = rendered.counters.hits;
    rendered.counters.hits = own_hits;
    trace.counters = rendered.counters;
    result.statistics = sim::statistics_object(tracer_statistics(scene, traced));
    result.statistics.update(sim::statistics_object(tracer_host_statistics(scene, rendered)));
    images.take(quality.order, traced);
    const Images& own = images.at(quality.order);
    if (quality.fp64) {
      compare_with(own, reference.images, reference.pixels, quality);
    } else {
      compare_with(own, precise.empty() ? own : precise, {}, quality);
    }
  }
  std::vector<TracedDesigns> all = of_machines(asked, images, comparison);
  for (TracedDesigns& on : all) on.files_hash = files.hash();
  return all;
}

}  // namespace grtx::experiment
