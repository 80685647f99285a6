// All of `grtx ray`, as a function: how rays of a trace were traced, as one HTML page.
#pragma once

#include <cstddef>
#include <functional>
#include <string>

#include "grtx/base/files_read.h"
#include "grtx/study/ray_choice.h"
#include "grtx/study/view_choice.h"

namespace grtx::sim {

struct RayPlan {
  std::string trace;  ///< file
  RayChoice rays;
  std::string scene;                             ///< of the trace: rays are traced again; "": they are not
  ViewOptions view;                              ///< with a scene; without a resolution the trace's
  bool recorded_view = true;                     ///< the view whose camera the trace names, in place of view.view
  std::string timeline;                          ///< what grtx sim --timeline wrote; "": no time axis
  std::function<void(const FilesRead&)> opened;  ///< called with all files of scene and cameras that were read
};

struct RayStudy {
  std::string page;  ///< HTML
  std::size_t rays = 0, rounds = 0, events = 0;
  bool traced_again = false;
};

/// Throws Error when there are no such rays, or the scene is not that of the trace.
RayStudy study_rays(const RayPlan& plan);

}  // namespace grtx::sim
