// grtx trace --no-trace --tracing tiles: the image of a view by tile tracing.
#pragma once

#include <string>

#include "grtx/apps/grtx/commands.h"
#include "grtx/apps/grtx/options.h"
#include "grtx/apps/grtx/tracer_cli.h"
#include "grtx/frontend/accel/acceleration_structure.h"

namespace grtx::sim {

/// Renders, and writes image and statistics where a path is given. Throws Error for options whose image tile tracing
/// cannot give.
int render_tile_view(const std::string& scene_file, const ViewOptions& view, frontend::AccelKind accel,
                     const TracerCli& cli, const std::string& image, const std::string& statistics,
                     const CommonOptions& common);

}  // namespace grtx::sim
