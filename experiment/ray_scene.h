// SPDX-License-Identifier: Apache-2.0
// The scene of a trace, for tracing single rays again with the tracer options recorded in the trace's header.
#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "grtx/base/files_read.h"
#include "grtx/experiment/tracer_settings.h"
#include "grtx/experiment/view_choice.h"
#include "grtx/frontend/tracer/ray_watch.h"
#include "grtx/frontend/tracer/scene_tracer.h"
#include "grtx/frontend/tracer/secondary_plan.h"
#include "grtx/report/ray/ray_page.h"
#include "grtx/traces/header.h"

namespace grtx::experiment {

class RayScene {
 public:
  /// view: camera of the frame whose rays are traced; without a resolution it takes the trace's. files: records the
  /// files opened. Throws Error if the scene is not the one of the trace.
  RayScene(const std::string& trace, const traces::Header& header, const std::string& scene, ViewOptions view,
           FilesRead& files);

  /// Traces a ray again. Throws Error naming the trace if any event differs from the recorded one.
  report::RayValues trace(const traces::RayGroup& group, unsigned lane);
  /// Fills in Gaussians and boxes of the nodes.
  void describe(std::vector<report::RayNode>& nodes) const;
  report::DrawnGaussian gaussian(std::uint32_t number) const;

 private:
  /// State of a ray at its start.
  struct Start {
    frontend::TraceRay ray;
    float limit = std::numeric_limits<float>::infinity();
    float transmittance = 1.0f;
  };
  Start start_of(const traces::RayGroup& group, unsigned lane) const;
  /// Throws Error at the first difference between the recorded ray and the ray traced again.
  void require_same_events(const traces::RayGroup& group, const traces::Ray& recorded, const traces::Ray& found) const;

  const std::string trace_;
  const traces::Header& header_;
  const std::string path_;
  const TracerSettings settings_;
  const frontend::TracerOptions options_;
  frontend::Camera camera_;
  frontend::SceneTracer scene_;
  frontend::SecondaryPlan plan_;
};

}  // namespace grtx::experiment
