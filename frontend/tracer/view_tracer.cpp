// SPDX-License-Identifier: Apache-2.0
#include "grtx/frontend/tracer/view_tracer.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include "grtx/base/error.h"
#include "grtx/base/hash.h"
#include "grtx/frontend/accel/acceleration_structure.h"
#include "grtx/frontend/accel/multi_object.h"
#include "grtx/frontend/gaussian/prepared_gaussians.h"
#include "grtx/frontend/gaussian/response_precision.h"
#include "grtx/frontend/tracer/tracer.h"
#include "grtx/traces/writer.h"

namespace grtx::frontend {
namespace {

constexpr float kLargestFp16 = 65504.0f;

/// Header of a trace of all frames. header_of(camera, options of the frame): header of a trace of one frame.
template <typename HeaderOf>
traces::Header sequence_header(const std::vector<Camera>& cameras, const std::vector<RenderOptions>& render,
                               HeaderOf&& header_of) {
  traces::Header header = header_of(cameras.front(), render.front());
  if (cameras.size() == 1) return header;
  header.frame_groups = {header.groups};
  std::string hashes = header.inputs["camera_hash"];
  for (std::size_t i = 1; i < cameras.size(); ++i) {
    header.frame_groups.push_back(header_of(cameras[i], render[i]).groups);
    header.groups += header.frame_groups.back();
    hashes += hex(cameras[i].hash());
  }
  header.inputs["camera_hash"] = hex(xxh3(hashes));
  header.inputs["camera"] = cameras.front().name + " to " + cameras.back().name;
  return header;
}

void add_frame(RenderResult& sum, const RenderResult& frame) {
  sum.counters.add(frame.counters);
  sum.secondary.add(frame.secondary);
  sum.footprint_bytes = std::max(sum.footprint_bytes, frame.footprint_bytes);
  sum.seconds += frame.seconds;
}

void add_plan(SecondaryPlan& sum, const SecondaryPlan& frame) {
  const auto first = static_cast<std::uint32_t>(sum.rays.size());
  for (SecondaryGroup group : frame.groups) {
    group.first += first;
    sum.groups.push_back(group);
  }
  sum.rays.insert(sum.rays.end(), frame.rays.begin(), frame.rays.end());
  sum.truncated += frame.truncated;
}

/// Renders frame after frame, and writes a trace unless trace_file is "". render: by frame.
void trace_into(TracedView& view, const TracedStructure& structure, const std::vector<Camera>& cameras,
                const TracerOptions& options, std::vector<RenderOptions> render, traces::Header header,
                const std::string& trace_file, const std::map<std::string, std::string>& inputs) {
  if (!trace_file.empty() && header.gaussians == 0) {
    throw Error(header.inputs["scene"], "", "has no Gaussians, so there is nothing to trace");
  }
  header.inputs.insert(inputs.begin(), inputs.end());
  view.inputs = header.inputs;
  std::optional<traces::Writer> writer;
  if (!trace_file.empty()) writer.emplace(trace_file, header);
  std::uint64_t first_group = 0;
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    render[i].first_group = first_group;
    RenderResult frame = frontend::render(structure, cameras[i], options, render[i], writer ? &*writer : nullptr);
    if (i == 0) {
      view.result = std::move(frame);
    } else {
      add_frame(view.result, frame);
      view.further.push_back(std::move(frame.image));
    }
    if (!header.frame_groups.empty()) first_group += header.frame_groups[i];
  }
  if (writer) {
    writer->finish();
    view.trace =
        TraceFile{writer->bytes(), writer->totals().visits(), writer->decoded_bytes(), writer->largest_group()};
  }
}

const std::vector<Camera>& checked(const std::vector<Camera>& cameras) {
  if (cameras.empty()) throw std::logic_error("a sequence has one frame or more");
  for (const Camera& camera : cameras) {
    if (camera.width == cameras.front().width && camera.height == cameras.front().height) continue;
    throw Error("camera " + camera.name, "", "a sequence has one resolution: that of camera " + cameras.front().name);
  }
  return cameras;
}

}  // namespace

ViewTracer::ViewTracer(Scene scene, Camera camera, Kernel kernel)
    : ViewTracer(std::move(scene), std::vector<Camera>{std::move(camera)}, kernel) {}

ViewTracer::ViewTracer(Scene scene, std::vector<Camera> cameras, Kernel kernel)
    : scene_(std::move(scene)),
      cameras_(checked(cameras)),
      kernel_(kernel),
      gaussians_(std::make_unique<PreparedGaussians>(scene_, kernel)) {}

ViewTracer::~ViewTracer() = default;

void ViewTracer::look(const std::vector<Camera>& cameras) { cameras_ = checked(cameras); }

const AccelerationStructure& ViewTracer::build(const AccelOptions& options) {
  if (accel_ != nullptr && accel_->options() == options) return *accel_;
  accel_.reset();
  if (gaussians_->quantised() != is_quantised(options.layout)) {
    gaussians_ = std::make_unique<PreparedGaussians>(scene_, kernel_, is_quantised(options.layout));
    round_sh(is_quantised(options.layout));
  }
  accel_ = std::make_unique<AccelerationStructure>(*gaussians_, options);
  ++structures_built_;
  return *accel_;
}

void ViewTracer::round_sh(bool quantised) {
  if (!quantised) {
    scene_.sh = std::move(full_sh_);
    clamped_sh_ = 0;
    return;
  }
  full_sh_ = scene_.sh;
  for (float& coefficient : scene_.sh) {
    const float rounded = round_to_fp16(std::clamp(coefficient, -kLargestFp16, kLargestFp16));
    clamped_sh_ += std::fabs(coefficient) > kLargestFp16 ? 1 : 0;
    coefficient = rounded;
  }
}

TracedView ViewTracer::trace(const TracerOptions& options, const RenderOptions& render, const std::string& trace_file,
                             const std::map<std::string, std::string>& inputs) const {
  if (accel_ == nullptr) throw std::logic_error("a view is traced in a structure: build() comes first");
  if (options.kernel != kernel_) throw std::logic_error("the Gaussians have another kernel");
  TracedView view;
  std::vector<SecondaryPlan> plans;
  for (const Camera& camera : cameras_) {
    plans.push_back(plan_secondary(scene_, *gaussians_, *accel_, camera, options, objects_, render.linear_mapping,
                                   render.threads, render.warp_size));
  }
  std::vector<RenderOptions> all_rays(cameras_.size(), render);
  for (std::size_t i = 0; i < cameras_.size(); ++i) all_rays[i].secondary = &plans[i];
  traces::Header header = sequence_header(cameras_, all_rays, [&](const Camera& camera, const RenderOptions& frame) {
    return trace_header(scene_, camera, *accel_, options, frame);
  });
  if (clamped_sh_ != 0) {
    header.inputs["clamped_sh"] = std::to_string(clamped_sh_) + " of " + std::to_string(scene_.sh.size());
  }
  trace_into(view, TracedStructure(scene_, *gaussians_, *accel_), cameras_, options, std::move(all_rays),
             std::move(header), trace_file, inputs);
  view.plan = std::move(plans.front());
  for (std::size_t i = 1; i < plans.size(); ++i) add_plan(view.plan, plans[i]);
  return view;
}

ObjectViewTracer::ObjectViewTracer(std::string name, std::vector<Scene> scenes,
                                   const std::vector<Placement>& placements, std::vector<Camera> cameras,
                                   const AccelOptions& options, Kernel kernel)
    : name_(std::move(name)),
      cameras_(checked(cameras)),
      kernel_(kernel),
      world_(std::make_unique<MultiObjectWorld>(std::move(scenes), placements, options, kernel)) {}

ObjectViewTracer::~ObjectViewTracer() = default;

void ObjectViewTracer::move(const std::vector<Placement>& placements) { world_->move(placements); }

void ObjectViewTracer::look(const std::vector<Camera>& cameras) { cameras_ = checked(cameras); }

TracedView ObjectViewTracer::trace(const TracerOptions& options, const RenderOptions& render,
                                   const std::string& trace_file,
                                   const std::map<std::string, std::string>& inputs) const {
  if (options.kernel != kernel_) throw std::logic_error("the Gaussians have another kernel");
  TracedView view;
  RenderOptions primary_rays = render;
  primary_rays.secondary = nullptr;
  traces::Header header = sequence_header(
      cameras_, std::vector(cameras_.size(), primary_rays),
      [&](const Camera& camera, const RenderOptions& frame) { return trace_header(*world_, camera, options, frame); });
  header.inputs["scene"] = name_;
  header.inputs["scene_hash"] = world_->hash();
  trace_into(view, TracedStructure(*world_), cameras_, options, std::vector(cameras_.size(), primary_rays),
             std::move(header), trace_file, inputs);
  return view;
}

}  // namespace grtx::frontend
