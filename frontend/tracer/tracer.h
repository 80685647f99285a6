// SPDX-License-Identifier: Apache-2.0
// Renders a view: rays into groups, groups over threads, image, counters and trace out.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "grtx/frontend/accel/acceleration_structure.h"
#include "grtx/frontend/camera/camera.h"
#include "grtx/frontend/gaussian/prepared_gaussians.h"
#include "grtx/frontend/image/image.h"
#include "grtx/frontend/scene/scene.h"
#include "grtx/frontend/tracer/render_options.h"
#include "grtx/frontend/tracer/traced_structure.h"
#include "grtx/frontend/tracer/tracer_counters.h"
#include "grtx/frontend/tracer/tracer_options.h"
#include "grtx/traces/writer.h"

namespace grtx::frontend {

inline constexpr unsigned kGroupRays = 32;  ///< unless RenderOptions::warp_size says otherwise

/// Pixels of each group, in lane order: tiles, row by row, or runs of `warp_size`. A tile of 32 is 8x4 pixels, of 16
/// 4x4, of 8 4x2, of 4 2x2. Throws Error for any other warp size.
std::vector<std::vector<std::uint32_t>> map_pixels(unsigned width, unsigned height, bool linear,
                                                   unsigned warp_size = kGroupRays);

/// Header of the trace that render() will write for these inputs. Secondary groups follow the primary ones.
traces::Header trace_header(const Scene& scene, const Camera& camera, const AccelerationStructure& accel,
                            const TracerOptions& options, const RenderOptions& render);
traces::Header trace_header(const MultiObjectWorld& world, const Camera& camera, const TracerOptions& options,
                            const RenderOptions& render);

/// Number of proxy hits of all rays of a view, those of render.secondary included: up to the surface that ends a ray,
/// but beyond early ray termination. It depends on the rays and on the proxy alone, not on how either is traced. Traces
/// the view without early termination, skipping all that it may.
std::uint64_t count_hits(const TracedStructure& structure, const Camera& camera, const TracerOptions& options,
                         const RenderOptions& render);

/// writer: nullptr renders only. The image, counters and trace are the same for any number of threads. Several objects
/// have no secondary rays.
RenderResult render(const TracedStructure& structure, const Camera& camera, const TracerOptions& options,
                    const RenderOptions& render, traces::Writer* writer);
RenderResult render(const Scene& scene, const PreparedGaussians& gaussians, const AccelerationStructure& accel,
                    const Camera& camera, const TracerOptions& options, const RenderOptions& render,
                    traces::Writer* writer);

}  // namespace grtx::frontend
