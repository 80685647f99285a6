// SPDX-License-Identifier: Apache-2.0
// INRIA 3DGS .ply: one vertex element whose properties carry a Gaussian's raw parameters.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "grtx/frontend/scene/ply_elements.h"
#include "grtx/frontend/scene/ply_header.h"
#include "grtx/frontend/scene/scene_rows.h"

namespace grtx::frontend {

/// Reads properties by name: in any order and of any scalar type; other properties and elements are skipped. The number
/// of f_rest_N properties (0, 9, 24, 45, 72) gives the SH degree. Throws Error{file, place, rule}.
RawRows read_ply(std::string_view bytes, const PlyHeader& header, const std::string& file);

/// SH degree of an element, from its properties f_rest_0 ...; throws Error when their number fits no degree or one is
/// missing.
unsigned sh_degree_of(const PlyElement& element, const std::string& file);

/// Columns for those properties: channel-major in the file, coefficient-major with r, g, b inner in `sh`.
void append_sh_columns(const PlyElement& element, unsigned degree, float* sh, std::vector<PlyColumn>& columns);

/// Index of a required property, which must not be a list. Throws Error.
std::size_t required_property(const PlyElement& element, const std::string& property, const std::string& file);

}  // namespace grtx::frontend
