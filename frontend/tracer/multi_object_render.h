// Renders a view of several objects. No trace: the format knows one level of instances.
#pragma once

#include "grtx/frontend/accel/multi_object.h"
#include "grtx/frontend/camera/camera.h"
#include "grtx/frontend/tracer/tracer.h"

namespace grtx::frontend {

/// render.secondary and count_unique are not looked at. The result is the same for any number of threads.
RenderResult render_objects(const MultiObjectWorld& world, const Camera& camera, const TracerOptions& options,
                            const RenderOptions& render);

}  // namespace grtx::frontend
