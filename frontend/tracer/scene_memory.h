// SPDX-License-Identifier: Apache-2.0
// Contents of the GPU's memory for a traced view: node image, records that shaders read, and the picture.
#pragma once

#include <string>

#include "grtx/frontend/tracer/view_tracer.h"

namespace grtx::frontend {

/// Writes the memory contents of a view that was just traced into `trace_file` (traces/memory_contents.h). Throws Error
/// for a sequence, or if a file cannot be read or written.
void write_scene_memory(const std::string& path, const std::string& trace_file, const ViewTracer& view,
                        const TracedView& traced);

}  // namespace grtx::frontend
