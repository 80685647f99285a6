// SPDX-License-Identifier: Apache-2.0
// `grtx ray` as a function: makes an HTML page that shows how rays of a trace were traced.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "grtx/base/files_read.h"
#include "grtx/experiment/ray_choice.h"
#include "grtx/experiment/view_choice.h"

namespace grtx::experiment {

struct RayPlan {
  std::string trace;  ///< file
  RayChoice rays;
  std::string scene;                             ///< scene of the trace, for tracing the rays again; "": they are not
  ViewOptions view;                              ///< used with a scene; default resolution: the trace's
  bool recorded_view = true;                     ///< take the view recorded in the trace, not view.view
  std::string image;                             ///< picture of the view to mark the pixel in; "": none
  std::vector<std::string> beside;               ///< other traces of the view, for the same pixel
  std::string timeline;                          ///< file from grtx sim --timeline; "": no time axis
  std::function<void(const FilesRead&)> opened;  ///< called with all scene and camera files that were read
};

struct RayStudy {
  std::string page;  ///< HTML
  std::size_t rays = 0, rounds = 0, events = 0;
  bool traced_again = false;
};

/// Throws Error if there are no such rays or the scene is not the one of the trace.
RayStudy study_rays(const RayPlan& plan);

}  // namespace grtx::experiment
