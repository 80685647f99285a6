// .splat: 32 bytes a Gaussian without a header; colour without view dependence.
#pragma once

#include <string>
#include <string_view>

#include "grtx/frontend/scene/scene_rows.h"

namespace grtx::frontend {

/// The format has no magic number. True when the size is a multiple of 32 and most rows hold a position and a scale
/// that a scene can have.
bool is_splat(std::string_view bytes);

/// Precondition: is_splat(bytes).
RawRows read_splat(std::string_view bytes);

}  // namespace grtx::frontend
