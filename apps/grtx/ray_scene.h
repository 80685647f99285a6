// The scene of a trace, so that single rays of it can be traced again with the options that its header names.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "grtx/apps/grtx/options.h"
#include "grtx/apps/grtx/tracer_cli.h"
#include "grtx/base/files_read.h"
#include "grtx/frontend/tracer/ray_watch.h"
#include "grtx/frontend/tracer/scene_tracer.h"
#include "grtx/frontend/tracer/secondary_plan.h"
#include "grtx/traces/header.h"
#include "grtx/view/ray/ray_page.h"

namespace grtx::sim {

/// The tracer's options of a trace, from Header::inputs. Throws Error that names the file `trace`.
TracerCli traced_options(const std::string& trace, const traces::Header& header);

class RayScene {
 public:
  /// view: of the frame whose rays are traced; without a resolution it takes the trace's. files: takes what is opened.
  /// Throws Error when the scene is not that of the trace.
  RayScene(const std::string& trace, const traces::Header& header, const std::string& scene, ViewOptions view,
           FilesRead& files);

  /// Traces a ray of the trace again. Throws Error, naming `trace`, unless it does what the trace says, event for
  /// event.
  RayValues trace(const traces::RayGroup& group, unsigned lane);
  /// Fills in what the nodes hold, and their boxes.
  void describe(std::vector<RayNode>& nodes) const;
  DrawnGaussian gaussian(std::uint32_t number) const;

 private:
  const std::string trace_;
  const traces::Header& header_;
  const std::string path_;
  const TracerCli cli_;
  const frontend::TracerOptions options_;
  frontend::Camera camera_;
  frontend::SceneTracer scene_;
  frontend::SecondaryPlan plan_;
};

}  // namespace grtx::sim
