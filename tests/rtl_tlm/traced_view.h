// SPDX-License-Identifier: Apache-2.0
// A small view of a scene as a trace file, for tests that want real ray groups.
#pragma once

#include <string>

#include "grtx/frontend/accel/acceleration_structure.h"
#include "grtx/frontend/camera/camera.h"
#include "grtx/frontend/scene/scene_io.h"
#include "grtx/frontend/tracer/tracer.h"
#include "grtx/traces/writer.h"

namespace grtx::sim::test {

/// Traces `width` x `height` pixels of the camera's view with one design and writes them to `path`.
inline void write_view(const std::string& path, const frontend::Scene& scene, const frontend::Camera& view,
                       unsigned width, unsigned height, frontend::AccelKind kind,
                       const frontend::TracerOptions& options,
                       traces::NodeLayout layout = traces::NodeLayout::vulkan_sim) {
  const frontend::Camera camera = view.resized(width, height);
  frontend::RenderOptions render{.threads = 1};
  const frontend::PreparedGaussians gaussians(scene, options.kernel);
  const frontend::AccelerationStructure accel(gaussians, {kind, traces::default_width(layout), false, 8, layout});
  traces::Writer writer(path, frontend::trace_header(scene, camera, accel, options, render));
  frontend::render(scene, gaussians, accel, camera, options, render, &writer);
  writer.finish();
}
inline void write_view(const std::string& path, const frontend::Scene& scene, const frontend::Camera& view,
                       unsigned width, unsigned height, frontend::AccelKind kind, bool checkpoint) {
  frontend::TracerOptions options;
  options.checkpoint = checkpoint;
  write_view(path, scene, view, width, height, kind, options);
}

}  // namespace grtx::sim::test
