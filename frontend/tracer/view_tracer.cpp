#include "grtx/frontend/tracer/view_tracer.h"

#include <stdexcept>
#include <utility>

#include "grtx/traces/writer.h"

namespace grtx::frontend {

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
  traces::Header header = trace_header(scene_, camera_, *accel_, options, all_rays);
  header.inputs.insert(inputs.begin(), inputs.end());
  view.inputs = header.inputs;
  std::optional<traces::Writer> writer;
  if (!trace_file.empty()) writer.emplace(trace_file, header);
  view.result = frontend::render(scene_, gaussians_, *accel_, camera_, options, all_rays, writer ? &*writer : nullptr);
  if (writer) {
    writer->finish();
    view.trace = TraceFile{writer->bytes(), writer->totals().visits()};
  }
  return view;
}

}  // namespace grtx::frontend
