// SPDX-License-Identifier: Apache-2.0
// One call from scene to picture.
#pragma once

#include "grtx/frontend/tracer/tracer.h"

namespace grtx::test {

inline frontend::RenderResult trace_scene(const frontend::Scene& scene, const frontend::Camera& camera,
                                          const frontend::AccelerationStructure& accel,
                                          const frontend::PreparedGaussians& gaussians,
                                          const frontend::TracerOptions& options) {
  frontend::RenderOptions render{.threads = 1, .keep_sequences = true};
  return frontend::render(scene, gaussians, accel, camera, options, render, nullptr);
}

inline frontend::RenderResult trace_scene(const frontend::Scene& scene, const frontend::Camera& camera,
                                          frontend::AccelKind kind, const frontend::TracerOptions& options,
                                          unsigned width = 6, bool corners = false) {
  const frontend::PreparedGaussians gaussians(scene, options.kernel);
  const frontend::AccelerationStructure accel(gaussians, {kind, width, corners});
  return trace_scene(scene, camera, accel, gaussians, options);
}

}  // namespace grtx::test
