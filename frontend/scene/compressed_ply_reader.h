// SPDX-License-Identifier: Apache-2.0
// PlayCanvas compressed .ply: 16 bytes per Gaussian, quantised between the limits of its chunk of 256, and SH in bytes.
#pragma once

#include <string>
#include <string_view>

#include "grtx/frontend/scene/ply_header.h"
#include "grtx/frontend/scene/scene_rows.h"

namespace grtx::frontend {

/// True when the header has an element "chunk" and packed vertices.
bool is_compressed_ply(const PlyHeader& header);

/// Throws Error{file, place, rule}.
RawRows read_compressed_ply(std::string_view bytes, const PlyHeader& header, const std::string& file);

}  // namespace grtx::frontend
