// SPDX-License-Identifier: Apache-2.0
// Renders a view by tile tracing (no trace), with its statistics.
#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <string>

#include "grtx/base/files_read.h"
#include "grtx/experiment/tracer_settings.h"
#include "grtx/experiment/view_choice.h"
#include "grtx/frontend/accel/acceleration_structure.h"
#include "grtx/frontend/image/image.h"
#include "grtx/frontend/tiles/tile_tracer.h"

namespace grtx::experiment {

struct TileView {
  frontend::TileResult result;
  double seconds = 0.0;             ///< tracing alone, without loading and building; above 0
  nlohmann::ordered_json document;  ///< grtx.stats/1
};

/// opened: called with all files read, before rendering. Throws Error for options that tile tracing does not support.
TileView render_tile_view(const std::string& scene_file, const ViewOptions& view, frontend::AccelKind accel,
                          const TracerSettings& settings, bool quiet,
                          const std::function<void(const FilesRead&)>& opened = nullptr);

}  // namespace grtx::experiment
