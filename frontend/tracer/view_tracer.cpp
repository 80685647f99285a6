#include "grtx/frontend/tracer/view_tracer.h"

#include <stdexcept>
#include <utility>

#include "grtx/traces/writer.h"

namespace grtx::frontend {
namespace {

/// Renders, and writes a trace unless trace_file is "".
void trace_into(TracedView& view, const TracedStructure& structure, const Camera& camera, const TracerOptions& options,
                const RenderOptions& render, traces::Header header, const std::string& trace_file,
                const std::map<std::string, std::string>& inputs) {
  header.inputs.insert(inputs.begin(), inputs.end());
  view.inputs = header.inputs;
  std::optional<traces::Writer> writer;
  if (!trace_file.empty()) writer.emplace(trace_file, header);
  view.result = frontend::render(structure, camera, options, render, writer ? &*writer : nullptr);
  if (writer) {
    writer->finish();
    view.trace = TraceFile{writer->bytes(), writer->totals().visits()};
  }
}

}  // namespace

ViewTracer::ViewTracer(Scene scene, Camera camera, Kernel kernel)
    : scene_(std::move(scene)), camera_(std::move(camera)), kernel_(kernel), gaussians_(scene_, kernel) {}

const AccelerationStructure& ViewTracer::build(const AccelOptions& options) {
  if (accel_ != nullptr && accel_->options() == options) return *accel_;
  accel_.reset();
  accel_ = std::make_unique<AccelerationStructure>(gaussians_, options);
  return *accel_;
}

TracedView ViewTracer::trace(const TracerOptions& options, const RenderOptions& render, const std::string& trace_file,
                             const std::map<std::string, std::string>& inputs) const {
  if (accel_ == nullptr) throw std::logic_error("a view is traced in a structure: build() comes first");
  if (options.kernel != kernel_) throw std::logic_error("the Gaussians have another kernel");
  TracedView view;
  view.plan = plan_secondary(scene_, gaussians_, *accel_, camera_, options, objects_, render.linear_mapping,
                             render.threads, render.warp_size);
  RenderOptions all_rays = render;
  all_rays.secondary = &view.plan;
  trace_into(view, TracedStructure(scene_, gaussians_, *accel_), camera_, options, all_rays,
             trace_header(scene_, camera_, *accel_, options, all_rays), trace_file, inputs);
  return view;
}

ObjectViewTracer::ObjectViewTracer(std::string name, std::vector<Scene> scenes,
                                   const std::vector<Placement>& placements, Camera camera, const AccelOptions& options,
                                   Kernel kernel)
    : name_(std::move(name)),
      camera_(std::move(camera)),
      kernel_(kernel),
      world_(std::move(scenes), placements, options, kernel) {}

TracedView ObjectViewTracer::trace(const TracerOptions& options, const RenderOptions& render,
                                   const std::string& trace_file,
                                   const std::map<std::string, std::string>& inputs) const {
  if (options.kernel != kernel_) throw std::logic_error("the Gaussians have another kernel");
  TracedView view;
  RenderOptions primary_rays = render;
  primary_rays.secondary = nullptr;
  traces::Header header = trace_header(world_, camera_, options, primary_rays);
  header.inputs["scene"] = name_;
  header.inputs["scene_hash"] = world_.hash();
  trace_into(view, TracedStructure(world_), camera_, options, primary_rays, std::move(header), trace_file, inputs);
  return view;
}

}  // namespace grtx::frontend
